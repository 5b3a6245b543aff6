// SPDX-License-Identifier: Apache-2.0
// How often this thread has asked for memory, and what happens where there is none. A program that links allocations.cpp has its operators new
// counted.
#pragma once

#include <cstddef>

namespace seaway::tests {

std::size_t allocations_of_this_thread();

/// While it lives, on its thread.
class Allocations {
  public:
    std::size_t count() const { return allocations_of_this_thread() - before_; }

  private:
    std::size_t before_ = allocations_of_this_thread();
};

/// While it lives, on its thread: of what is asked for the one after so many gets nothing (std::bad_alloc).
class NoMemoryOnce {
  public:
    explicit NoMemoryOnce(std::size_t after);
    ~NoMemoryOnce();
    NoMemoryOnce(const NoMemoryOnce&) = delete;
    NoMemoryOnce& operator=(const NoMemoryOnce&) = delete;
};

} // namespace seaway::tests
