// bricking/import/files/nrrd/nrrd_header.cpp: see nrrd_header.h. Rules: teem's "Definition of NRRD File
// Format".
#include "bricking/import/files/nrrd/nrrd_header.h"

#include "bricking/import/files/nrrd/nrrd_fields.h"
#include "core/base/error.h"

#include <algorithm>
#include <array>
#include <limits>
#include <set>
#include <string_view>
#include <utility>

namespace tessera {
namespace {

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
    explicit HeaderReader(const InputFile& file)
        : path_(file.path()), where_(path_.string()), lines_(file, "NRRD") {}

    NrrdHeader read() {
        const std::optional<std::string> magic = lines_.next();
        if (!magic || magic->size() != 8 || !magic->starts_with("NRRD000") || (*magic)[7] < '1' ||
            (*magic)[7] > '5')
            throw badFile(where_, "an NRRD file (NRRD0001 to NRRD0005)",
                          magic && magic->starts_with("NRRD") ? "version " + shownWord(magic->substr(4))
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
                          shownWord(line));
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
                          shownWord(text));
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
                throw badFile(where_, "\"sizes\" of 2^58 values at most", shownWord(required("sizes")));
            values *= static_cast<std::uint64_t>(header_.sizes[axis]);
        }
    }

    void readCoding() {
        const std::string& type = required("type");
        const std::optional<FileType> known = nrrdTypeOf(lowered(type));
        if (!known)
            throw badFile(where_, "a \"type\" of numbers, such as unsigned char or short", shownWord(type));
        header_.type = *known;
        const std::string encoding = lowered(required("encoding"));
        if (encoding == "raw")
            header_.encoding = DataEncoding::raw;
        else if (encoding == "gzip" || encoding == "gz")
            header_.encoding = DataEncoding::gzip;
        else if (encoding == "text" || encoding == "txt" || encoding == "ascii")
            header_.encoding = DataEncoding::text;
        else
            throw badFile(where_, "\"encoding\" raw, gzip or text", shownWord(encoding));
        const bool hasOrder = header_.encoding != DataEncoding::text && bytesPerFileValue(header_.type) > 1;
        if (const std::string* endian = optional("endian"); endian && lowered(*endian) == "big")
            header_.bigEndian = true;
        else if (endian ? lowered(*endian) != "little" : hasOrder)
            throw badFile(where_, "\"endian\" little or big", endian ? shownWord(*endian) : "no such field");
        constexpr std::int64_t kMostSkip = std::int64_t{1} << 53;
        if (const std::string* skip = optional("lineskip"))
            header_.lineSkip = whole(*skip, "line skip", 0, kMostSkip);
        if (const std::string* skip = optional("byteskip"))
            header_.byteSkip = whole(*skip, "byte skip", -1, kMostSkip);
        if (header_.byteSkip == -1 && header_.encoding != DataEncoding::raw)
            throw badFile(where_, "\"byte skip\" of -1 with raw data alone", shownWord(encoding) + " data");
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
                    throw badFile(where_, "\"spacings\" of numbers", shownWord(*text));
                header_.spacings.push_back(*value);
            }
        if (const std::string* text = optional("kinds"))
            for (const std::string& word : perAxis("kinds", wordsOf(*text)))
                header_.kinds.push_back(lowered(word));
        if (const std::string* text = optional("spaceunits"))
            header_.spaceUnits = textsOf(*text);
        if (const std::string* text = optional("sampleunits"))
            header_.sampleUnits = *text;
        if (const std::string* text = optional("units"))
            header_.units = textsOf(*text);
    }

    glm::dvec3 vectorOf(const std::string& text) const {
        const std::optional<glm::dvec3> vector = nrrdVectorOf(text);
        if (!vector)
            throw badFile(where_, "vectors of three finite numbers, (x,y,z), in the NRRD header",
                          shownWord(text));
        return *vector;
    }

    void readDataFiles() {
        const std::string* data = optional("datafile");
        if (data && data->empty())
            throw badFile(where_, "a name after \"data file\"", "none (is it truncated?)");
        if (data)
            header_.dataFiles = namedDataFiles("data file", *data, listed_, header_.sizes, path_);
    }

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
