// bricking/import/labels/nrrd/nrrd_header.cpp: see nrrd_header.h. Rules: teem's "Definition of NRRD File
// Format".
#include "bricking/import/labels/nrrd/nrrd_header.h"

#include "bricking/import/labels/nrrd/nrrd_fields.h"
#include "core/base/error.h"
#include "core/base/shown_text.h"

#include <algorithm>
#include <array>
#include <limits>
#include <set>
#include <string_view>
#include <utility>

namespace tessera {
namespace {

constexpr std::size_t kPortionBytes = 64 * 1024;

std::string shortText(std::string_view text) {
    constexpr std::size_t kMostShown = 60;
    return "\"" + printable(text.substr(0, kMostShown)) + (text.size() > kMostShown ? "..." : "") + "\"";
}

/// Lines of a header, read as they are needed.
class HeaderLines {
  public:
    explicit HeaderLines(const InputFile& file) : file_(file) {}

    /// The next line without its end; nullopt at the end of the file.
    std::optional<std::string> next() {
        std::size_t end = text_.find('\n', at_);
        for (std::size_t seen = at_; end == std::string::npos; end = text_.find('\n', seen)) {
            seen = text_.size();
            if (seen > kMostNrrdHeaderBytes)
                throw badFile(file_.path().string(), "an NRRD header of 16 MiB at most", "a longer one");
            text_.resize(seen + kPortionBytes);
            const auto room = std::as_writable_bytes(std::span(text_)).subspan(seen);
            text_.resize(seen + file_.readSome(seen, room));
            if (text_.size() == seen)
                break;
        }
        if (at_ == text_.size())
            return std::nullopt;
        std::string line = text_.substr(at_, end == std::string::npos ? end : end - at_);
        at_ = end == std::string::npos ? text_.size() : end + 1;
        if (line.ends_with('\r'))
            line.pop_back();
        return line;
    }
    std::uint64_t readBytes() const { return at_; }

  private:
    const InputFile& file_;
    std::string text_;
    std::size_t at_ = 0;
};

std::string unescaped(std::string_view text) {
    std::string out;
    for (std::size_t i = 0; i < text.size(); ++i) {
        if (text[i] == '\\' && i + 1 < text.size() && (text[i + 1] == 'n' || text[i + 1] == '\\'))
            out += text[++i] == 'n' ? '\n' : '\\';
        else
            out += text[i];
    }
    return out;
}

/// One header while it is read: fields by their names without blanks.
class HeaderReader {
  public:
    explicit HeaderReader(const InputFile& file) : path_(file.path()), where_(path_.string()), lines_(file) {}

    NrrdHeader read() {
        const std::optional<std::string> magic = lines_.next();
        if (!magic || magic->size() != 8 || !magic->starts_with("NRRD000") || (*magic)[7] < '1' ||
            (*magic)[7] > '5')
            throw badFile(where_, "an NRRD file (NRRD0001 to NRRD0005)",
                          magic && magic->starts_with("NRRD") ? "version " + shortText(magic->substr(4))
                                                              : "another beginning");
        bool isComplete = false;
        while (!isComplete) {
            const std::optional<std::string> line = lines_.next();
            if (!line)
                break;
            if (line->empty())
                isComplete = true;
            else if (!line->starts_with('#'))
                takeLine(*line);
        }
        isComplete = isComplete || fields_.contains("datafile"); // a detached header may end with its file
        if (!isComplete)
            throw badFile(where_, "a blank line after the NRRD header, or a field \"data file\"",
                          "the end of the file (is it truncated?)");
        header_.bytes = lines_.readBytes();
        interpret();
        return std::move(header_);
    }

  private:
    void takeLine(const std::string& line) {
        const std::size_t colon = line.find(':');
        const std::size_t pair = line.find(":=");
        if (colon == std::string::npos)
            throw badFile(where_, "lines \"field: value\" or \"key:=value\" in the NRRD header",
                          shortText(line));
        const std::string name = nrrdFieldName(std::string_view(line).substr(0, colon));
        const bool isField = isNrrdField(name) && line[std::min(colon + 1, line.size() - 1)] != '=';
        if (!isField && pair != std::string::npos) {
            header_.pairs[unescaped(std::string_view(line).substr(0, pair))] =
                unescaped(std::string_view(line).substr(pair + 2));
            return;
        }
        if (!isField)
            return;
        const std::string value(withoutBlanks(std::string_view(line).substr(colon + 1)));
        if (!fields_.emplace(name, value).second)
            throw badFile(where_, "every NRRD field once", "\"" + name + "\" again");
        if (name == "datafile" && value.starts_with("LIST"))
            while (const std::optional<std::string> file = lines_.next())
                if (!withoutBlanks(*file).empty())
                    listed_.emplace_back(withoutBlanks(*file));
    }

    const std::string& required(const std::string& name) const {
        const auto at = fields_.find(name);
        if (at == fields_.end())
            throw badFile(where_, "the NRRD field \"" + name + "\"", "a header without it");
        return at->second;
    }
    const std::string* optional(const std::string& name) const {
        const auto at = fields_.find(name);
        return at == fields_.end() ? nullptr : &at->second;
    }
    std::int64_t whole(const std::string& text, const std::string& name, std::int64_t least,
                       std::int64_t most) const {
        const std::optional<std::int64_t> value = wholeNumberOf(text);
        if (!value || *value < least || *value > most)
            throw badFile(where_,
                          "\"" + name + "\" as a whole number from " + std::to_string(least) + " to " +
                              std::to_string(most),
                          shortText(text));
        return *value;
    }
    std::vector<std::string> perAxis(const std::string& name, std::vector<std::string> words) const {
        if (words.size() != header_.sizes.size())
            throw badFile(where_,
                          "\"" + name + "\" of " + std::to_string(header_.sizes.size()) +
                              " axes, as \"dimension\" says",
                          std::to_string(words.size()) + " values");
        return words;
    }

    void interpret() {
        readShape();
        readCoding();
        readSpace();
        readDataFiles();
    }

    void readShape() {
        const std::int64_t axes =
            whole(required("dimension"), "dimension", 1, static_cast<std::int64_t>(kMostNrrdAxes));
        header_.sizes.resize(static_cast<std::size_t>(axes));
        std::uint64_t values = 1;
        const std::vector<std::string> sizes = perAxis("sizes", wordsOf(required("sizes")));
        for (std::size_t axis = 0; axis < sizes.size(); ++axis) {
            header_.sizes[axis] = whole(sizes[axis], "sizes", 1, std::numeric_limits<std::int32_t>::max());
            constexpr std::uint64_t kMostValues = std::uint64_t{1} << 58;
            if (values > kMostValues / static_cast<std::uint64_t>(header_.sizes[axis]))
                throw badFile(where_, "\"sizes\" of 2^58 values at most", shortText(required("sizes")));
            values *= static_cast<std::uint64_t>(header_.sizes[axis]);
        }
    }

    void readCoding() {
        const std::string& type = required("type");
        const std::optional<FileType> known = nrrdTypeOf(lowered(type));
        if (!known)
            throw badFile(where_, "a \"type\" of numbers, such as unsigned char or short", shortText(type));
        header_.type = *known;
        const std::string encoding = lowered(required("encoding"));
        if (encoding == "raw")
            header_.encoding = NrrdEncoding::raw;
        else if (encoding == "gzip" || encoding == "gz")
            header_.encoding = NrrdEncoding::gzip;
        else if (encoding == "text" || encoding == "txt" || encoding == "ascii")
            header_.encoding = NrrdEncoding::text;
        else
            throw badFile(where_, "\"encoding\" raw, gzip or text", shortText(encoding));
        const bool hasOrder = header_.encoding != NrrdEncoding::text && bytesPerFileValue(header_.type) > 1;
        if (const std::string* endian = optional("endian"); endian && lowered(*endian) == "big")
            header_.bigEndian = true;
        else if (endian ? lowered(*endian) != "little" : hasOrder)
            throw badFile(where_, "\"endian\" little or big", endian ? shortText(*endian) : "no such field");
        constexpr std::int64_t kMostSkip = std::int64_t{1} << 53;
        if (const std::string* skip = optional("lineskip"))
            header_.lineSkip = whole(*skip, "line skip", 0, kMostSkip);
        if (const std::string* skip = optional("byteskip"))
            header_.byteSkip = whole(*skip, "byte skip", -1, kMostSkip);
        if (header_.byteSkip == -1 && header_.encoding != NrrdEncoding::raw)
            throw badFile(where_, "\"byte skip\" of -1 with raw data alone", shortText(encoding) + " data");
    }

    void readSpace() {
        if (const std::string* space = optional("space"))
            header_.space = lowered(*space);
        if (const std::string* dimension = optional("spacedimension"))
            whole(*dimension, "space dimension", 3, 3);
        if (const std::string* text = optional("spacedirections"))
            for (const std::string& word : perAxis("space directions", vectorsOf(*text)))
                header_.directions.push_back(lowered(word) == "none" ? std::nullopt
                                                                     : std::optional(vectorOf(word)));
        if (const std::string* text = optional("spaceorigin"))
            header_.origin = vectorOf(*text);
        if (const std::string* text = optional("spacings"))
            for (const std::string& word : perAxis("spacings", wordsOf(*text))) {
                const std::optional<double> value = realNumberOf(word);
                if (!value)
                    throw badFile(where_, "\"spacings\" of numbers", shortText(*text));
                header_.spacings.push_back(*value);
            }
        if (const std::string* text = optional("kinds"))
            for (const std::string& word : perAxis("kinds", wordsOf(*text)))
                header_.kinds.push_back(lowered(word));
        if (const std::string* text = optional("spaceunits"))
            header_.spaceUnits = textsOf(*text);
    }

    glm::dvec3 vectorOf(const std::string& text) const {
        const std::optional<glm::dvec3> vector = nrrdVectorOf(text);
        if (!vector)
            throw badFile(where_, "vectors of three finite numbers, (x,y,z), in the NRRD header",
                          shortText(text));
        return *vector;
    }

    void readDataFiles() {
        const std::string* data = optional("datafile");
        if (!data)
            return;
        std::vector<std::string> names = listed_;
        const auto axes = static_cast<std::int64_t>(header_.sizes.size());
        // As many files as there are runs of `each` axes; of all axes: parts along the slowest one.
        std::int64_t each = axes - 1;
        const std::vector<std::string> words = wordsOf(*data);
        if (data->starts_with("LIST")) {
            if (words[0] != "LIST" || words.size() > 2 || names.empty())
                throw badFile(where_, "\"data file: LIST\" and names, a line each", shortText(*data));
            if (words.size() == 2)
                each = whole(words[1], "data file", 1, axes);
        } else if (words.size() >= 4 && words[0].find('%') != std::string::npos) {
            if (words.size() > 5)
                throw badFile(where_, "\"data file\" as PATTERN MIN MAX STEP", shortText(*data));
            if (words.size() == 5)
                each = whole(words[4], "data file", 1, axes);
            names = patternNames(words);
        } else {
            header_.dataFiles = {beside(*data)};
            return;
        }
        std::uint64_t runs = each == axes ? static_cast<std::uint64_t>(header_.sizes.back()) : 1;
        for (std::int64_t axis = each; axis < axes; ++axis)
            runs *= static_cast<std::uint64_t>(header_.sizes[static_cast<std::size_t>(axis)]);
        if (each == axes ? runs % names.size() != 0 : runs != names.size())
            throw badFile(where_, std::to_string(runs) + " data files, as \"sizes\" says",
                          std::to_string(names.size()));
        for (const std::string& name : names)
            header_.dataFiles.push_back(beside(name));
    }

    std::vector<std::string> patternNames(const std::vector<std::string>& words) const {
        constexpr std::int64_t kMostNumber = 999'999'999;
        const std::int64_t first = whole(words[1], "data file", 0, kMostNumber),
                           last = whole(words[2], "data file", 0, kMostNumber),
                           step = whole(words[3], "data file", -kMostNumber, kMostNumber);
        if (step == 0 || (last - first) / step < 0)
            throw badFile(where_, "a step of \"data file\" that leads from its first number to its last",
                          std::to_string(step));
        const std::int64_t count = (last - first) / step + 1;
        if (count > std::max<std::int64_t>(header_.sizes.back(), kMostFiles))
            throw badFile(where_, "at most one data file a slice", std::to_string(count));
        std::vector<std::string> names;
        for (std::int64_t i = 0; i < count; ++i) {
            const std::optional<std::string> name = numberedName(words[0], first + i * step);
            if (!name)
                throw badFile(where_, "one %d in the pattern of \"data file\"", shortText(words[0]));
            names.push_back(*name);
        }
        return names;
    }

    std::filesystem::path beside(const std::string& name) const { return path_.parent_path() / name; }

    static constexpr std::int64_t kMostFiles = 65536;
    std::filesystem::path path_;
    std::string where_;
    HeaderLines lines_;
    NrrdHeader header_;
    std::map<std::string, std::string> fields_;
    std::vector<std::string> listed_; // data files
};

} // namespace

bool beginsAsNrrd(const InputFile& file) {
    std::array<char, 7> head{};
    return file.readSome(0, std::as_writable_bytes(std::span(head))) == head.size() &&
           std::string_view(head.data(), head.size()) == "NRRD000";
}

NrrdHeader readNrrdHeader(const InputFile& file) {
    return HeaderReader(file).read();
}

} // namespace tessera
