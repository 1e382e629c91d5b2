// tests/support/counted_heap.h: the bytes that a test program holds by `new`, that of libraries too: now, and
// the most so far. To be included by one source of a program. Sanitizers have their own, and count nothing.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdlib>
#include <malloc.h>
#include <new>

namespace {
std::atomic<std::size_t> liveBytes{0}, peakBytes{0};
} // namespace

#ifndef __SANITIZE_ADDRESS__ // which has its own
namespace {
void* counted(std::size_t bytes) {
    void* const at = std::malloc(bytes == 0 ? 1 : bytes);
    if (!at)
        throw std::bad_alloc();
    const std::size_t live = liveBytes += malloc_usable_size(at);
    std::size_t peak = peakBytes;
    while (peak < live && !peakBytes.compare_exchange_weak(peak, live)) {
    }
    return at;
}
void uncounted(void* at) {
    if (at)
        liveBytes -= malloc_usable_size(at);
    std::free(at);
}
} // namespace

void* operator new(std::size_t bytes) {
    return counted(bytes);
}
void* operator new[](std::size_t bytes) {
    return counted(bytes);
}
void operator delete(void* at) noexcept {
    uncounted(at);
}
void operator delete[](void* at) noexcept {
    uncounted(at);
}
void operator delete(void* at, std::size_t) noexcept {
    uncounted(at);
}
void operator delete[](void* at, std::size_t) noexcept {
    uncounted(at);
}
#endif
