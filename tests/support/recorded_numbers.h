// tests/support/recorded_numbers.h: numbers that must not change unnoticed, in a file of the checkout.
// TESSERA_RECORD=1 writes them anew.
#pragma once

#include "tests/support/folders.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <gtest/gtest.h>
#include <sstream>
#include <string>
#include <vector>

namespace tessera::test {

class RecordedNumbers {
  public:
    /// @param file  below the folder of the sources
    explicit RecordedNumbers(const std::string& file) : file_(sourceFolder() / file) {
        std::ifstream in(file_);
        for (std::string line; !writes_ && std::getline(in, line);)
            lines_.push_back(line);
    }
    RecordedNumbers(const RecordedNumbers&) = delete;
    RecordedNumbers& operator=(const RecordedNumbers&) = delete;
    ~RecordedNumbers() {
        if (!writes_) {
            EXPECT_EQ(next_, lines_.size()) << file_ << " has more";
            return;
        }
        std::ofstream out(file_);
        for (const std::string& line : lines_)
            out << line << "\n";
    }

    /// The next line of the file. Rounding of other machines stays below the tolerances.
    /// @param name  one word
    /// @param share, least  of differences: the larger counts
    void expect(const std::string& name, const std::vector<double>& numbers, double share = 1e-5,
                double least = 1e-4) {
        if (writes_) {
            std::string line = name;
            for (const double number : numbers) {
                char text[32];
                std::snprintf(text, sizeof text, " %.10g", number);
                line += text;
            }
            lines_.push_back(line);
            return;
        }
        std::istringstream in(next_ < lines_.size() ? lines_[next_] : "");
        ++next_;
        std::string was;
        in >> was;
        EXPECT_EQ(was, name) << file_;
        std::vector<double> recorded;
        for (std::string text; in >> text;)
            recorded.push_back(std::strtod(text.c_str(), nullptr));
        ASSERT_EQ(numbers.size(), recorded.size()) << name;
        for (std::size_t i = 0; i < numbers.size(); ++i) {
            const bool same = recorded[i] == numbers[i]; // infinite ones, too
            ASSERT_TRUE(same ||
                        std::abs(numbers[i] - recorded[i]) <= std::max(least, share * std::abs(recorded[i])))
                << name << ", number " << i << ": recorded " << recorded[i] << ", found " << numbers[i];
        }
    }

  private:
    const std::filesystem::path file_;
    const bool writes_ = std::getenv("TESSERA_RECORD") != nullptr;
    std::vector<std::string> lines_;
    std::size_t next_ = 0;
};

} // namespace tessera::test
