// tests/viewer/annotations/words_test.cpp: random words, broken and cut: nothing is lost unsaid, no line is
// too wide, and none could hold more.
#include "viewer/annotations/words.h"

#include "tests/support/figures.h"

#include <gtest/gtest.h>
#include <random>
#include <sstream>
#include <string>
#include <vector>

namespace tessera {
namespace {

using test::evenLetters;

constexpr double kPixels = 10, kLetter = 6; // of evenLetters()
const std::string kEllipsis = "\xe2\x80\xa6";

std::size_t lettersOf(const std::string& words) {
    return static_cast<std::size_t>(evenLetters(words, kPixels).width / kLetter + 0.5);
}
std::vector<std::string> wordsOf(const std::string& text) {
    std::istringstream in(text);
    std::vector<std::string> words;
    for (std::string word; in >> word;)
        words.push_back(word);
    return words;
}
std::string joined(const std::vector<std::string>& lines) {
    std::string text;
    for (const std::string& line : lines)
        text += (text.empty() ? "" : " ") + line;
    return text;
}

TEST(CutWords, KeepAsManyLettersAsFit) {
    std::mt19937 random(1);
    const std::string letters[] = {"a", " ", "\xc3\xa4", "\xe8\x82\x9d", "b"};
    for (int n = 0; n < 500; ++n) {
        std::string words;
        for (auto k = random() % 20; k > 0; --k)
            words += letters[random() % 5];
        const std::size_t room = random() % 22;
        const std::string cut =
            cutWords(words, kPixels, kLetter * (static_cast<double>(room) + 0.5), evenLetters);
        if (lettersOf(words) <= room) {
            EXPECT_EQ(cut, words);
            continue;
        }
        if (room == 0) {
            EXPECT_EQ(cut, "");
            continue;
        }
        ASSERT_TRUE(cut.ends_with(kEllipsis)) << words;
        std::string kept = cut.substr(0, cut.size() - kEllipsis.size());
        EXPECT_TRUE(words.starts_with(kept));
        EXPECT_FALSE(kept.ends_with(" "));
        while (words[kept.size()] == ' ') // which are not shown before an ellipsis
            kept += ' ';
        EXPECT_GE(lettersOf(kept) + 1, room) << words;
        EXPECT_LE(lettersOf(cut), room);
        EXPECT_NE(static_cast<unsigned char>(words[kept.size()]) & 0xC0, 0x80) << "whole letters";
    }
}

TEST(BrokenWords, FillTheirLinesAndLoseNothingUnsaid) {
    std::mt19937 random(2);
    int whole = 0, cut = 0;
    for (int n = 0; n < 2000; ++n) {
        std::string text;
        for (auto word = random() % 12; word > 0; --word) {
            text += std::string(1 + random() % 7, static_cast<char>('a' + static_cast<int>(word)));
            text += random() % 5 == 0 ? "\n" : random() % 4 == 0 ? "  " : " ";
        }
        const std::size_t room = 3 + random() % 14, most = random() % 5;
        const BrokenWords broken =
            brokenWords(text, kPixels, kLetter * (static_cast<double>(room) + 0.5), most, evenLetters);
        SCOPED_TRACE(text + ", " + std::to_string(room) + " letters, " + std::to_string(most));
        EXPECT_LE(broken.lines.size(), most);
        for (const std::string& line : broken.lines) {
            EXPECT_LE(lettersOf(line), room);
            EXPECT_FALSE(line.empty());
        }
        const std::vector<std::string> asked = wordsOf(text), shown = wordsOf(joined(broken.lines));
        EXPECT_EQ(broken.cut, asked != shown);
        (broken.cut ? cut : whole) += 1;
        // Words of one paragraph are on as few lines as hold them: none had room on the line before.
        std::size_t next = 0;
        std::istringstream paragraphs(text);
        std::vector<std::size_t> paragraphOf; // of each word
        std::size_t number = 0;
        for (std::string paragraph; std::getline(paragraphs, paragraph); ++number)
            paragraphOf.insert(paragraphOf.end(), wordsOf(paragraph).size(), number);
        if (broken.cut)
            continue;
        for (std::size_t line = 0; line < broken.lines.size(); ++line) {
            const std::size_t count = wordsOf(broken.lines[line]).size();
            next += count;
            if (line + 1 == broken.lines.size())
                break;
            if (paragraphOf[next - 1] == paragraphOf[next]) {
                EXPECT_GT(lettersOf(broken.lines[line] + " " + asked[next]), room);
            }
            EXPECT_EQ(paragraphOf[next - count], paragraphOf[next - 1])
                << "a line feed ends a line but the last";
        }
    }
    EXPECT_GT(whole, 300);
    EXPECT_GT(cut, 300);
}

} // namespace
} // namespace tessera
