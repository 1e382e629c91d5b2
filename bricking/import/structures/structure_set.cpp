// bricking/import/structures/structure_set.cpp: see structure_set.h. DCMTK's dcmdata reads the elements. Its
// dcmrt is not used: it makes objects of all attributes of every contour, copies of the data besides.
#include "bricking/import/structures/structure_set.h"

#include "bricking/import/dicom/dicom_structure.h"
#include "bricking/import/dicom/items/dicom_items.h"
#include "bricking/import/source/source_files.h"
#include "core/base/dicom_uid.h"
#include "core/base/error.h"
#include "core/base/shown_text.h"
#include "core/image/colour.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <map>
#include <set>
#include <string_view>

namespace tessera {
namespace {

constexpr std::string_view kStructures = "1.2.840.10008.5.1.4.1.1.481.3";
constexpr std::array<std::string_view, 3> kPlainSyntaxes = {"1.2.840.10008.1.2", "1.2.840.10008.1.2.1",
                                                            "1.2.840.10008.1.2.2"};
constexpr double kMostMm = 1e6;
/// Memory of DCMTK's object for an element or item, and of all copies of a byte of text and its numbers.
constexpr std::uint64_t kBytesOfObject = 512, kBytesOfByte = 12;

struct ContourKind {
    std::string_view name;
    ContourForm form;
};
constexpr std::array<ContourKind, 5> kContourKinds = {{{"POINT", ContourForm::points},
                                                       {"OPEN_PLANAR", ContourForm::line},
                                                       {"OPEN_NONPLANAR", ContourForm::line},
                                                       {"CLOSED_PLANAR", ContourForm::ring},
                                                       {"CLOSEDPLANAR_XOR", ContourForm::ring}}};

class StructureReader {
  public:
    StructureReader(const std::filesystem::path& file, MemoryBudget& ram)
        : file_(file), where_(file.string()), ram_(ram) {}

    StructureSet read() {
        silenceDcmtk();
        const Charge charge = checkFile();
        DcmFileFormat format;
        if (format.loadFile(where_.c_str(), EXS_Unknown, EGL_noChange).bad())
            refuse("a DICOM file", "a header that cannot be read");
        DcmDataset& data = *format.getDataset();
        if (itemText(data, DCM_SOPClassUID) != kStructures)
            refuse("a DICOM RT Structure Set (SOPClassUID)", "another object");
        characters_ = itemText(data, DCM_SpecificCharacterSet);
        frame_ = frameOf(data);
        forEachItem(data, DCM_StructureSetROISequence, [&](DcmItem& item) { readStructure(item); });
        if (structures_.empty())
            refuse("a StructureSetROISequence (3006,0020)", "none");
        forEachItem(data, DCM_ROIContourSequence, [&](DcmItem& item) { readContours(item); });
        for (auto& [number, structure] : structures_)
            if (structure.contours.empty())
                set_.notes.push_back("structure " + nameOf(structure) + " has no contours and is left out");
            else
                set_.structures.push_back(std::move(structure));
        if (set_.structures.empty())
            refuse("structures with contours", std::to_string(structures_.size()) + " without");
        return std::move(set_);
    }

  private:
    [[noreturn]] void refuse(const std::string& expected, const std::string& found) const {
        throw badFile(where_, expected, found);
    }
    static std::string nameOf(const Structure& s) {
        return std::to_string(s.label.value) + " \"" + s.label.name + "\"";
    }

    /// Walks over the file before DCMTK sees it.
    Charge checkFile() {
        if (const std::string storage = storageClassOf(file_); storage != kStructures)
            refuse("a DICOM RT Structure Set",
                   storage.empty() ? "no DICOM file with its kind" : "another DICOM object");
        const DicomStructure structure = structureOf(file_);
        if (structure.breaksOff || structure.elements == 0)
            refuse("a whole DICOM file", structure.irregularity + " (is it truncated?)");
        if (std::find(kPlainSyntaxes.begin(), kPlainSyntaxes.end(), structure.syntax) == kPlainSyntaxes.end())
            refuse("a structure set that is not compressed",
                   "transfer syntax " + printable(structure.syntax));
        if (!structure.irregularity.empty())
            set_.notes.push_back("the file is irregular: " + structure.irregularity);
        return ram_.charge(structure.elements * kBytesOfObject + InputFile(file_).sizeBytes() * kBytesOfByte,
                           "reading " + printable(file_.filename().string()));
    }

    template <typename Visit>
    static void forEachItem(DcmItem& item, const DcmTagKey& tag, const Visit& visit) {
        DcmSequenceOfItems* sequence = nullptr;
        if (item.findAndGetSequence(tag, sequence).good())
            for (DcmObject* at = nullptr; (at = sequence->nextInContainer(at)) != nullptr;)
                visit(*static_cast<DcmItem*>(at));
    }

    /// The frame of reference of all structures; "" where there are several, or none.
    static std::string frameOf(DcmDataset& data) {
        std::set<std::string> frames;
        forEachItem(data, DCM_ReferencedFrameOfReferenceSequence, [&](DcmItem& item) {
            frames.insert(uidOrNone(itemText(item, DCM_FrameOfReferenceUID)));
        });
        if (frames.empty())
            return uidOrNone(itemText(data, DCM_FrameOfReferenceUID));
        return frames.size() == 1 ? *frames.begin() : std::string();
    }

    /// A whole number (IS), from 0 on. nullopt: absent or empty.
    std::optional<std::uint32_t> wholeOf(DcmItem& item, const DcmTagKey& tag, const std::string& name) const {
        std::string_view text;
        const std::string own = itemText(item, tag);
        text = own;
        if (text.empty())
            return std::nullopt;
        if (text.front() == '+')
            text.remove_prefix(1);
        std::int32_t value = -1;
        const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), value);
        if (error != std::errc{} || stop != text.data() + text.size() || value < 0)
            refuse(name + ", a whole number from 0 to 2147483647",
                   "\"" + printable(text.substr(0, 40)) + "\"");
        return static_cast<std::uint32_t>(value);
    }

    void readStructure(DcmItem& item) {
        const auto number = wholeOf(item, DCM_ROINumber, "ROINumber (3006,0022)");
        if (!number)
            refuse("ROINumber (3006,0022) in every structure", "none");
        Structure structure;
        structure.label.value = *number;
        structure.label.name = itemWords(item, DCM_ROIName, characters_);
        if (structure.label.name.empty())
            structure.label.name = "structure " + std::to_string(*number);
        structure.frameOfReference = uidOrNone(itemText(item, DCM_ReferencedFrameOfReferenceUID));
        if (structure.frameOfReference.empty())
            structure.frameOfReference = frame_;
        if (!structures_.emplace(*number, std::move(structure)).second)
            refuse("structures of different numbers", "several of number " + std::to_string(*number));
    }

    void readContours(DcmItem& item) {
        const auto number = wholeOf(item, DCM_ReferencedROINumber, "ReferencedROINumber (3006,0084)");
        if (!number)
            refuse("ReferencedROINumber (3006,0084) in every item of contours", "none");
        const auto at = structures_.find(*number);
        if (at == structures_.end())
            refuse("ReferencedROINumber (3006,0084) of a structure in StructureSetROISequence",
                   std::to_string(*number));
        if (!drawn_.insert(*number).second)
            refuse("one item of contours for a structure", "several for structure " + nameOf(at->second));
        if (const auto colour =
                itemReals(item, DCM_ROIDisplayColor, 3, "ROIDisplayColor (3006,002a)", where_)) {
            glm::vec3 linear;
            for (int c = 0; c < 3; ++c) {
                const double value = (*colour)[static_cast<std::size_t>(c)];
                if (!(value >= 0 && value <= 255))
                    refuse("ROIDisplayColor (3006,002a) from 0 to 255", numberText(value));
                linear[c] = static_cast<float>(linearFromSrgb(value / 255));
            }
            at->second.label.colour = linear;
        }
        forEachItem(item, DCM_ContourSequence, [&](DcmItem& one) { readContour(one, at->second); });
    }

    void readContour(DcmItem& item, Structure& structure) {
        const std::size_t order = ++contours_;
        const std::string which =
            " of contour " + std::to_string(order) + " of structure " + nameOf(structure);
        const std::string kindName = itemText(item, DCM_ContourGeometricType);
        const auto* const kind = std::find_if(kContourKinds.begin(), kContourKinds.end(),
                                              [&](const ContourKind& k) { return k.name == kindName; });
        if (kind == kContourKinds.end())
            refuse("ContourGeometricType (3006,0042) POINT, OPEN_PLANAR, OPEN_NONPLANAR, CLOSED_PLANAR or "
                   "CLOSEDPLANAR_XOR" +
                       which,
                   kindName.empty() ? "none" : "\"" + printable(kindName.substr(0, 40)) + "\"");
        const std::string countName = "NumberOfContourPoints (3006,0046)" + which;
        const auto count = wholeOf(item, DCM_NumberOfContourPoints, countName);
        if (!count || *count == 0)
            refuse(countName + " of at least 1", count ? "0" : "none");
        const std::string name = "ContourData (3006,0050)" + which;
        const std::vector<double> numbers = contourNumbers(item, name);
        if (numbers.size() != std::size_t{3} * *count)
            refuse(name + " of " + std::to_string(std::uint64_t{3} * *count) + " numbers, for " +
                       std::to_string(*count) + " points",
                   std::to_string(numbers.size()));
        for (const double number : numbers)
            if (!(std::abs(number) <= kMostMm))
                refuse(name + " within 1000000 mm", numberText(number));
        std::vector<glm::dvec3> points;
        points.reserve(*count);
        for (std::size_t n = 0; n < numbers.size(); n += 3)
            points.emplace_back(numbers[n], numbers[n + 1], numbers[n + 2]);
        if (kind->form == ContourForm::ring && points.size() > 1 && points.front() == points.back())
            points.pop_back();
        structure.contours.push_back({kind->form, std::move(points)});
    }

    /// Data above 64 KiB are of an unknown representation where lengths have 16 bits (PS3.5, 6.2.2).
    std::vector<double> contourNumbers(DcmItem& item, const std::string& name) const {
        DcmElement* element = nullptr;
        if (item.findAndGetElement(DCM_ContourData, element).bad() || element->getLength() == 0)
            return {};
        std::string_view text;
        char* words = nullptr;
        Uint32 length = 0;
        Uint8* bytes = nullptr;
        if (element->getString(words, length).good() && words)
            text = {words, length};
        else if (element->getUint8Array(bytes).good() && bytes)
            text = {reinterpret_cast<const char*>(bytes), element->getLength()};
        while (text.ends_with(' ') || text.ends_with('\0'))
            text.remove_suffix(1);
        if (text.empty())
            return {};
        return realsOf(text, name.c_str(), where_);
    }

    std::filesystem::path file_;
    std::string where_, characters_, frame_; // frame_: of reference
    MemoryBudget& ram_;
    StructureSet set_;
    std::map<std::uint32_t, Structure> structures_;
    std::set<std::uint32_t> drawn_; // numbers of structures whose contours were read
    std::size_t contours_ = 0;
};

} // namespace

StructureSet readStructureSet(const std::filesystem::path& file, MemoryBudget& ram) {
    return StructureReader(file, ram).read();
}

} // namespace tessera
