// bricking/import/labels/seg/seg_items.cpp: see seg_items.h.
#include "bricking/import/labels/seg/seg_items.h"

#include "core/base/error.h"

#include <charconv>
#include <cmath>
#include <dcmtk/oflog/oflog.h>
#include <mutex>
#include <string_view>
#include <system_error>

namespace tessera {

void silenceDcmtk() {
    static std::once_flag once;
    std::call_once(once, [] { OFLog::configure(OFLogger::OFF_LOG_LEVEL); });
}

std::string segText(DcmItem& item, const DcmTagKey& tag) {
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

std::optional<std::uint32_t> segNumber(DcmItem& item, const DcmTagKey& tag, unsigned long at) {
    Uint16 value = 0;
    if (item.findAndGetUint16(tag, value, at).bad())
        return std::nullopt;
    return value;
}

std::optional<std::vector<double>> segReals(DcmItem& item, const DcmTagKey& tag, std::size_t count,
                                            const char* name, const std::string& where) {
    const std::string text = segText(item, tag);
    if (text.empty())
        return std::nullopt;
    std::vector<double> values;
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
    if (values.size() != count)
        throw badFile(where, std::string(name) + " of " + std::to_string(count) + " numbers",
                      std::to_string(values.size()));
    return values;
}

DcmItem* segItem(DcmItem& item, const DcmTagKey& sequence) {
    DcmItem* found = nullptr;
    return item.findAndGetSequenceItem(sequence, found, 0).good() ? found : nullptr;
}

} // namespace tessera
