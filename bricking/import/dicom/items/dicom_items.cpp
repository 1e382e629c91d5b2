// bricking/import/dicom/items/dicom_items.cpp: see dicom_items.h.
#include "bricking/import/dicom/items/dicom_items.h"

#include "bricking/import/source/source_files.h"
#include "core/base/error.h"
#include "core/base/shown_text.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <dcmtk/dcmdata/dcspchrs.h>
#include <dcmtk/oflog/oflog.h>
#include <mutex>
#include <span>
#include <string_view>
#include <system_error>

namespace tessera {

void silenceDcmtk() {
    static std::once_flag once;
    std::call_once(once, [] { OFLog::configure(OFLogger::OFF_LOG_LEVEL); });
}

std::string itemText(DcmItem& item, const DcmTagKey& tag) {
    OFString value;
    if (item.findAndGetOFStringArray(tag, value).bad())
        return "";
    std::string_view text(value.c_str(), value.size());
    constexpr std::string_view kFilling(" \0", 2);
    const std::size_t begin = text.find_first_not_of(kFilling);
    if (begin == std::string_view::npos)
        return "";
    return std::string(text.substr(begin, text.find_last_not_of(kFilling) + 1 - begin));
}

std::string itemWords(DcmItem& item, const DcmTagKey& tag, const std::string& characters) {
    const std::string text = itemText(item, tag);
    if (!characters.empty() && characters != "ISO_IR 192") {
        DcmSpecificCharacterSet converter;
        OFString converted;
        if (converter.selectCharacterSet(characters.c_str()).good() &&
            converter.convertString(text.c_str(), converted).good())
            return printable(std::string_view(converted.c_str(), converted.size()));
    }
    return printable(text);
}

std::optional<std::uint32_t> itemNumber(DcmItem& item, const DcmTagKey& tag, unsigned long at) {
    Uint16 value = 0;
    if (item.findAndGetUint16(tag, value, at).bad())
        return std::nullopt;
    return value;
}

std::vector<double> realsOf(std::string_view text, const char* name, const std::string& where) {
    std::vector<double> values;
    values.reserve(1 + static_cast<std::size_t>(std::count(text.begin(), text.end(), '\\')));
    std::string_view rest = text;
    for (;;) {
        const std::size_t end = rest.find('\\');
        std::string_view part = rest.substr(0, end);
        while (part.starts_with(' ') || part.starts_with('+'))
            part.remove_prefix(1);
        while (part.ends_with(' '))
            part.remove_suffix(1);
        double value = 0;
        const auto [stop, error] = std::from_chars(part.data(), part.data() + part.size(), value);
        if (error != std::errc{} || stop != part.data() + part.size() || !std::isfinite(value))
            throw badFile(where, std::string(name) + " of finite numbers", "a text that is no number");
        values.push_back(value);
        if (end == std::string_view::npos)
            break;
        rest.remove_prefix(end + 1);
    }
    return values;
}

std::optional<std::vector<double>> itemReals(DcmItem& item, const DcmTagKey& tag, std::size_t count,
                                             const char* name, const std::string& where) {
    const std::string text = itemText(item, tag);
    if (text.empty())
        return std::nullopt;
    std::vector<double> values = realsOf(text, name, where);
    if (values.size() != count)
        throw badFile(where, std::string(name) + " of " + std::to_string(count) + " numbers",
                      std::to_string(values.size()));
    return values;
}

std::string storageClassOf(const std::filesystem::path& file) {
    try {
        std::error_code none;
        if (!std::filesystem::is_regular_file(file, none))
            return "";
        constexpr std::size_t kMetaBytes = 2048; // the meta group is short
        std::string head(kMetaBytes, '\0');
        head.resize(InputFile(file).readSome(0, std::as_writable_bytes(std::span(head))));
        const std::string_view meta = std::string_view(head).substr(std::min<std::size_t>(head.size(), 128));
        const std::size_t at = meta.find(std::string_view("\x02\x00\x02\x00UI", 6));
        if (!meta.starts_with("DICM") || at == std::string_view::npos || meta.size() - at < 8)
            return "";
        const auto length = static_cast<unsigned char>(meta[at + 6]); // of UIDs at most 64
        const std::string_view uid = meta.substr(at + 8, length);
        return std::string(uid.substr(0, uid.find_last_not_of(std::string_view("\0 ", 2)) + 1));
    } catch (const Error&) {
        return "";
    }
}

DcmItem* firstItem(DcmItem& item, const DcmTagKey& sequence) {
    DcmItem* found = nullptr;
    return item.findAndGetSequenceItem(sequence, found, 0).good() ? found : nullptr;
}

} // namespace tessera
