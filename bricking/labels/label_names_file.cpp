// bricking/labels/label_names_file.cpp: readLabelNames of label_names.h.
#include "bricking/labels/label_names_text.h"

#include "core/base/error.h"
#include "core/base/json_reader.h"
#include "core/base/shown_text.h"
#include "core/image/colour.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <map>
#include <set>
#include <system_error>

namespace tessera {
namespace {

using Words = std::vector<std::string>;

template <class T> std::optional<T> wholeText(std::string_view text) {
    T value{};
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    return error == std::errc{} && end == text.data() + text.size() ? std::optional(value) : std::nullopt;
}

std::string_view trimmed(std::string_view text) {
    const std::size_t begin = text.find_first_not_of(" \t\r");
    return begin == std::string_view::npos ? std::string_view()
                                           : text.substr(begin, text.find_last_not_of(" \t\r") + 1 - begin);
}

std::string lowerText(std::string_view text) {
    std::string out(text);
    for (char& c : out)
        c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
    return out;
}

/// One part of a colour in linear light: 0 to 255, or with a decimal point 0 to 1.
std::optional<float> colourPart(std::string_view text) {
    const std::optional<double> value = wholeText<double>(text);
    const double most = text.find('.') == std::string_view::npos ? 255 : 1;
    if (!value || !(*value >= 0 && *value <= most))
        return std::nullopt;
    return static_cast<float>(linearFromSrgb(*value / most));
}

std::optional<glm::vec3> colourOfParts(const std::string& r, const std::string& g, const std::string& b) {
    const auto red = colourPart(r), green = colourPart(g), blue = colourPart(b);
    return red && green && blue ? std::optional(glm::vec3(*red, *green, *blue)) : std::nullopt;
}

/// A line as words between blanks; a text in quotation marks is one.
Words wordsOfLine(std::string_view line) {
    Words words;
    for (line = trimmed(line); !line.empty(); line = trimmed(line)) {
        const bool isQuoted = line.front() == '"';
        const std::size_t end = isQuoted ? line.find('"', 1) : line.find_first_of(" \t\r");
        const std::size_t begin = isQuoted ? 1 : 0;
        words.emplace_back(line.substr(begin, end == std::string_view::npos ? end : end - begin));
        line.remove_prefix(end == std::string_view::npos ? line.size() : end + begin);
    }
    return words;
}

/// A line of CSV (RFC 4180) as fields, blanks around them aside.
Words fieldsOfLine(std::string_view line, char separator) {
    Words fields(1);
    bool isQuoted = false;
    for (std::size_t i = 0; i < line.size(); ++i) {
        const char c = line[i];
        if (isQuoted && c == '"' && i + 1 < line.size() && line[i + 1] == '"')
            fields.back() += line[i++];
        else if (c == '"')
            isQuoted = !isQuoted;
        else if (!isQuoted && c == separator)
            fields.emplace_back();
        else
            fields.back() += c;
    }
    for (std::string& field : fields)
        field = std::string(trimmed(field));
    return fields;
}

class NamesReader {
  public:
    explicit NamesReader(std::string where) : where_(std::move(where)) {}

    template <class TakeLine> std::vector<LabelName> read(const std::string& text, const TakeLine& takeLine) {
        std::string_view rest = text;
        if (rest.starts_with("\xef\xbb\xbf"))
            rest.remove_prefix(3);
        while (!rest.empty()) {
            const std::size_t end = std::min(rest.find('\n'), rest.size());
            line_ = trimmed(rest.substr(0, end));
            rest.remove_prefix(std::min(end + 1, rest.size()));
            ++number_;
            if (!line_.empty() && !line_.starts_with('#'))
                takeLine(*this);
        }
        if (names_.empty())
            throw badFile(where_, "names or colours of labels", "none");
        return std::move(names_);
    }

    void takeTableLine() {
        const Words words = wordsOfLine(line_);
        if (words.size() >= 8 && line_.ends_with('"'))
            return add(words[0], words[7], colourOfParts(words[1], words[2], words[3]), "");
        // VALUE NAME R G B, and an opacity where four numbers are behind the name, which may have blanks.
        const auto isNumber = [&](std::size_t fromEnd) {
            return words.size() >= 2 + fromEnd && wholeText<double>(words[words.size() - fromEnd]);
        };
        if (isNumber(1) && isNumber(2) && isNumber(3)) {
            const std::size_t r = words.size() - (isNumber(4) ? 4 : 3);
            std::string name = words[1];
            for (std::size_t i = 2; i < r; ++i)
                name += " " + words[i];
            if (const auto colour = colourOfParts(words[r], words[r + 1], words[r + 2]))
                return add(words[0], name, colour, "");
        }
        refuse("VALUE NAME R G B A, or VALUE R G B A VISIBLE MESH \"NAME\"");
    }

    void takeCsvLine() {
        if (separator_ == 0)
            separator_ =
                line_.find(',') == std::string_view::npos && line_.find(';') != std::string_view::npos ? ';'
                                                                                                       : ',';
        const Words fields = fieldsOfLine(line_, separator_);
        if (columns_.empty()) {
            if (!wholeText<std::uint32_t>(fields[0]))
                return takeCsvHeader(fields);
            columns_ = {{"value", 0}, {"name", 1}};
            if (fields.size() >= 5)
                columns_.insert({{"r", 2}, {"g", 3}, {"b", 4}});
            else
                columns_.emplace("colour", 2);
        }
        const auto field = [&](const char* name) {
            const auto at = columns_.find(name);
            return at != columns_.end() && at->second < fields.size() ? fields[at->second] : std::string();
        };
        std::optional<glm::vec3> colour;
        if (const std::string text = field("colour"); !text.empty()) {
            colour = findColour(text);
            if (!colour)
                refuse("a colour, #rrggbb or a name");
        } else if (!field("r").empty()) {
            colour = colourOfParts(field("r"), field("g"), field("b"));
            if (!colour)
                refuse("r, g and b from 0 to 255");
        }
        add(field("value"), field("name"), colour, field("group"));
    }

  private:
    [[noreturn]] void refuse(const std::string& expected) const {
        constexpr std::size_t kMostShown = 60;
        throw badFile(where_, expected + " in line " + std::to_string(number_),
                      "\"" + printable(line_.substr(0, kMostShown)) + "\"");
    }

    void takeCsvHeader(const Words& fields) {
        static const std::map<std::string, std::string> known = {{"value", "value"},  {"labelvalue", "value"},
                                                                 {"index", "value"},  {"id", "value"},
                                                                 {"name", "name"},    {"label", "name"},
                                                                 {"r", "r"},          {"red", "r"},
                                                                 {"color_r", "r"},    {"g", "g"},
                                                                 {"green", "g"},      {"color_g", "g"},
                                                                 {"b", "b"},          {"blue", "b"},
                                                                 {"color_b", "b"},    {"colour", "colour"},
                                                                 {"color", "colour"}, {"hex", "colour"},
                                                                 {"group", "group"},  {"category", "group"}};
        for (std::size_t i = 0; i < fields.size(); ++i)
            if (const auto at = known.find(lowerText(fields[i])); at != known.end())
                columns_.emplace(at->second, i);
        if (!columns_.contains("value") && !columns_.contains("name"))
            refuse("a header with a column value or name");
    }

    void add(const std::string& valueText, const std::string& name, const std::optional<glm::vec3>& colour,
             const std::string& group) {
        std::optional<std::uint32_t> value;
        if (!valueText.empty()) {
            value = wholeText<std::uint32_t>(valueText);
            if (!value)
                refuse("a value from 0 to 4294967295");
            if (!values_.insert(*value).second)
                refuse("every value once");
        }
        if (!value && name.empty())
            refuse("a value or a name");
        const bool isUnused = name == "(none)"; // 3D Slicer's rows without a name
        if (value != 0u && !isUnused)
            names_.push_back({value, printable(name), printable(group), colour});
    }

    std::string where_;
    std::string_view line_;
    std::size_t number_ = 0;
    char separator_ = 0;
    std::map<std::string, std::size_t> columns_;
    std::set<std::uint32_t> values_;
    std::vector<LabelName> names_;
};

} // namespace

std::vector<LabelName> readLabelNames(const std::filesystem::path& file) {
    const std::string where = file.string(), text = readTextFile(where);
    const std::string ending = lowerText(file.extension().string());
    if (ending == ".json") {
        std::vector<LabelName> names = labelNamesOfJson(text, where);
        std::erase_if(names, [](const LabelName& name) { return name.value == 0u; });
        return names;
    }
    if (ending == ".csv")
        return NamesReader(where).read(text, [](NamesReader& reader) { reader.takeCsvLine(); });
    return NamesReader(where).read(text, [](NamesReader& reader) { reader.takeTableLine(); });
}

} // namespace tessera
