// tests/support/refusals.h: the message with which something is refused.
#pragma once

#include "core/base/error.h"

#include <functional>
#include <string>

namespace tessera::test {

inline std::string refusalOf(const std::function<void()>& action) {
    try {
        action();
    } catch (const InputError& error) {
        return error.what();
    }
    return "no refusal";
}

} // namespace tessera::test
