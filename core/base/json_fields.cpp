// core/base/json_fields.cpp: see json_fields.h.
#include "core/base/json_fields.h"

#include <limits>

namespace tessera {
namespace {
template <typename T> nlohmann::json plainJson(const T& value) {
    return value;
}
} // namespace

Kind<double> anyNumber() {
    return {[](const JsonValue& value) { return value.number(); }, plainJson<double>,
            [](Schema&) {
                return Schema{{"type", "number"}};
            }};
}

Kind<double> numberIn(double lowest, double highest) {
    return {[=](const JsonValue& value) { return value.number(lowest, highest); }, plainJson<double>,
            [=](Schema&) {
                return Schema{{"type", "number"}, {"minimum", lowest}, {"maximum", highest}};
            }};
}

Kind<double> numberFrom(double lowest) {
    Kind<double> kind = numberIn(lowest, std::numeric_limits<double>::max());
    kind.schema = [=](Schema&) { return Schema{{"type", "number"}, {"minimum", lowest}}; };
    return kind;
}

Kind<int> wholeIn(int lowest, int highest) {
    return {[=](const JsonValue& value) { return value.integer(lowest, highest); }, plainJson<int>,
            [=](Schema&) {
                return Schema{{"type", "integer"}, {"minimum", lowest}, {"maximum", highest}};
            }};
}

Kind<bool> trueOrFalse() {
    return {[](const JsonValue& value) { return value.boolean(); }, plainJson<bool>,
            [](Schema&) {
                return Schema{{"type", "boolean"}};
            }};
}

Kind<std::string> anyText() {
    return {[](const JsonValue& value) { return value.text(); }, plainJson<std::string>,
            [](Schema&) {
                return Schema{{"type", "string"}};
            }};
}

Kind<std::string> oneOf(const std::vector<std::string>& names) {
    return {[names](const JsonValue& value) {
                value.oneOf(names);
                return value.text();
            },
            plainJson<std::string>,
            [names](Schema&) {
                return Schema{{"enum", names}};
            }};
}

} // namespace tessera
