// bricking/import/dicom/dicom_header.h: values of a parsed DICOM header, per frame. The functional groups of
// multi-frame files come before the top level. Numbers are read strictly: a text that is no number is a fault
// with the tag's name, never an absent value. Private to the DICOM importer.
#pragma once

#include "bricking/import/dicom/dicom_scan.h"

#include <array>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vtkDICOMDictionary.h>
#include <vtkDICOMItem.h>
#include <vtkDICOMMetaData.h>
#include <vtkDICOMValue.h>

namespace tessera {

class DicomHeader {
  public:
    explicit DicomHeader(vtkDICOMMetaData* data) : data_(data) {}
    /// For one item of a sequence, which has no frames.
    explicit DicomHeader(const vtkDICOMItem* item) : item_(item) {}

    /// Without padding blanks and zeros.
    std::string text(vtkDICOMTag tag, int frame = 0) const {
        const std::string value = valueOf(tag, frame).AsString();
        const std::string_view filling(" \0", 2);
        const std::size_t begin = value.find_first_not_of(filling), end = value.find_last_not_of(filling);
        return begin == std::string::npos ? "" : value.substr(begin, end + 1 - begin);
    }
    bool has(vtkDICOMTag tag) const { return data_->Has(tag); }
    /// The only item of a sequence; nothing if there are more, or none.
    std::optional<DicomHeader> itemOf(vtkDICOMTag sequence) const {
        const vtkDICOMValue& value = valueOf(sequence, 0);
        const vtkDICOMItem* items = value.GetSequenceData();
        return items && value.GetNumberOfValues() == 1 ? std::optional(DicomHeader(items)) : std::nullopt;
    }
    std::optional<int> integer(vtkDICOMTag tag, int frame = 0) const {
        const vtkDICOMValue& value = valueOf(tag, frame);
        if (!value.IsValid() || value.GetNumberOfValues() < 1)
            return std::nullopt;
        return value.AsInt();
    }

    /// Exactly N finite numbers, or nothing.
    template <int N> std::optional<std::array<double, N>> reals(vtkDICOMTag tag, int frame) const {
        std::optional<HeaderFault> ignored;
        return reals<N>(tag, frame, "", ignored);
    }
    /// The same; the first other content goes to `fault`: expected "RescaleSlope (0028,1053) of 1 finite
    /// number", found "a text that is no number". The text itself is never quoted: in a damaged header it may
    /// be anything.
    template <int N>
    std::optional<std::array<double, N>> reals(vtkDICOMTag tag, int frame, const char* name,
                                               std::optional<HeaderFault>& fault) const {
        const vtkDICOMValue& value = valueOf(tag, frame);
        if (!value.IsValid() || value.GetVL() == 0)
            return std::nullopt;
        std::array<double, N> out{};
        std::string found;
        const vtkDICOMVR vr = value.GetVR();
        if (vr.HasTextValue()) {
            found = parse(value.AsString(), out.data(), N);
            if (found == kBlank)
                return std::nullopt;
        } else if (value.GetNumberOfValues() != N) {
            found = std::to_string(value.GetNumberOfValues()) + " values";
        } else {
            for (std::size_t i = 0; i < N; ++i)
                out[i] = value.GetDouble(i);
        }
        for (std::size_t i = 0; i < N && found.empty(); ++i)
            if (!std::isfinite(out[i]))
                found = "a value that is not finite";
        if (found.empty())
            return out;
        if (!fault)
            fault = {std::string(name) + " of " + std::to_string(N) + " finite number" + (N > 1 ? "s" : ""),
                     found};
        return std::nullopt;
    }
    std::optional<double> real(vtkDICOMTag tag, int frame = 0) const {
        const auto value = reals<1>(tag, frame);
        return value ? std::optional((*value)[0]) : std::nullopt;
    }
    std::optional<double> real(vtkDICOMTag tag, int frame, const char* name,
                               std::optional<HeaderFault>& fault) const {
        const auto value = reals<1>(tag, frame, name, fault);
        return value ? std::optional((*value)[0]) : std::nullopt;
    }
    /// The last of several numbers: that of the last step.
    std::optional<double> last(vtkDICOMTag tag) const {
        const vtkDICOMValue& value = valueOf(tag, 0);
        if (!value.IsValid() || value.GetNumberOfValues() < 1)
            return std::nullopt;
        const double number = value.GetDouble(value.GetNumberOfValues() - 1);
        return std::isfinite(number) ? std::optional(number) : std::nullopt;
    }
    /// Seconds of the day of a TM value ("HHMMSS.FFFFFF") or of the time in a DT value.
    std::optional<double> seconds(vtkDICOMTag tag, int frame) const {
        const vtkDICOMValue& value = valueOf(tag, frame);
        if (!value.IsValid() || value.GetNumberOfValues() < 1)
            return std::nullopt;
        std::string digits = value.AsString();
        if (digits.size() >= 14 && digits.find_first_not_of("0123456789") >= 14)
            digits.erase(0, 8); // a date before it
        char* end = nullptr;
        const double number = std::strtod(digits.c_str(), &end);
        if (end == digits.c_str() || !(number >= 0 && number < 240000))
            return std::nullopt;
        const double hours = std::floor(number / 10000), minutes = std::floor(number / 100) - 100 * hours;
        return 3600 * hours + 60 * minutes + (number - 10000 * hours - 100 * minutes);
    }

  private:
    static constexpr const char* kBlank = "blank";

    /// Fills `count` numbers from "a\b\c"; returns the fault, or nothing.
    static std::string parse(const std::string& text, double* out, int count) {
        if (text.find_first_not_of(std::string(" \0", 2)) == std::string::npos)
            return kBlank; // an empty value is an absent one
        int found = 0;
        for (std::size_t begin = 0; begin <= text.size(); ++found) {
            const std::size_t end = std::min(text.find('\\', begin), text.size());
            const std::string part = text.substr(begin, end - begin);
            char* rest = nullptr;
            const double number = std::strtod(part.c_str(), &rest);
            // strtod accepts hexadecimal and "infinity" too, which are no decimal strings.
            if (rest == part.c_str() || part.find_first_of("xXpP") != std::string::npos ||
                std::string(rest).find_first_not_of(' ') != std::string::npos)
                return "a text that is no number";
            if (found < count)
                out[found] = number;
            begin = end + 1;
        }
        return found == count ? "" : std::to_string(found) + " values";
    }

    const vtkDICOMValue& valueOf(vtkDICOMTag tag, int frame) const {
        return item_ ? item_->Get(tag) : data_->Get(0, frame, tag);
    }

    vtkDICOMMetaData* data_ = nullptr;
    const vtkDICOMItem* item_ = nullptr; // instead of it
};

/// Short code words only, the content of a whitelist entry. Anything else is dropped, not shortened.
inline std::string codeWord(const std::string& text) {
    for (const char c : text) {
        const bool plain = (c >= '0' && c <= '9') || (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') ||
                           (c != '\0' && std::strchr("+-_./\\ ", c) != nullptr);
        if (!plain)
            return "";
    }
    return text.size() <= 16 ? text : "";
}

// Reads a frame's position, time, rescale and padding from the header. Private to the DICOM importer.

/// Tags of stored values (padding, extremes) have the sign of the pixels, whatever the file's own coding.
std::optional<std::int32_t> storedValueOf(std::optional<int> value, const DicomSlice& slice);

/// Fills these members of a slice whose number format is known. An invalid number goes to slice.fault.
void readPlace(const DicomHeader& header, int frame, DicomSlice& slice);

// The factor from a PET's activity to SUV by body weight, if the header has all values for it (QIBA, "SUV
// vendor-neutral pseudo-code"). Weight, dose and times are used and forgotten. Private to the DICOM importer.

struct SuvFactor {
    double perValue = 0; // SUVbw = perValue * value; 0: unknown
    std::string missing; // the reason if unknown: "PatientWeight (0010,1030)", or an invalid value of it
};

/// For a PET image. Nothing is guessed: values in other units, other decay corrections, and missing or
/// implausible doses, weights and times give no factor.
SuvFactor suvFactorOf(const DicomHeader& header);

// Keeps messages of VTK and vtk-dicom off the console. Their texts may quote header values, and an identifier
// must not reach a log. Our own errors say what went wrong.

/// While it lives, messages of VTK are suppressed. Not to be nested.
class QuietVtk {
  public:
    QuietVtk();
    ~QuietVtk();
    QuietVtk(const QuietVtk&) = delete;
    QuietVtk& operator=(const QuietVtk&) = delete;

  private:
    struct State;
    std::unique_ptr<State> state_;
};

} // namespace tessera
