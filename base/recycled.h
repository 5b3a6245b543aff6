// SPDX-License-Identifier: Apache-2.0
// RecycledVector: a std::vector of numbers that are not cleared, or of anything, whose memory is kept by the thread that gives it back, for the next one on that thread.
// For work that is done again and again and must not wait for the allocator: after the first time it allocates nothing.
//
// Blocks are powers of two; a thread keeps `recycled_bytes_max` at most and frees what is beyond, all of it when it ends. A vector
// may be given back by another thread than the one that it was made on: its memory stays there.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <new>
#include <utility>
#include <vector>

namespace seaway {

/// A batch of 50 000 answers fits in what is kept with the terms of each, beside what a search takes.
inline constexpr std::size_t recycled_bytes_max = std::size_t{16} << 20;

namespace recycled {

/// Blocks that a thread keeps, a list for each power of two.
class Blocks {
  public:
    Blocks() = default;
    Blocks(const Blocks&) = delete;
    Blocks& operator=(const Blocks&) = delete;
    ~Blocks() {
        for (Block*& first : first_)
            while (Block* block = first) {
                first = block->next;
                ::operator delete(block);
            }
    }

    static Blocks& of_this_thread() {
        static thread_local Blocks blocks;
        return blocks;
    }
    void* take(std::size_t bytes) {
        const std::size_t kind = kind_of(bytes);
        Block*& first = first_[kind];
        if (first == nullptr)
            return ::operator new (std::size_t{1} << kind);
        Block* const block = first;
        first = block->next;
        kept_bytes_ -= std::size_t{1} << kind;
        return block;
    }
    void give(void* memory, std::size_t bytes) noexcept {
        const std::size_t kind = kind_of(bytes);
        const std::size_t more_bytes = std::size_t{1} << kind;
        if (kept_bytes_ + more_bytes > recycled_bytes_max) {
            ::operator delete(memory);
            return;
        }
        kept_bytes_ += more_bytes;
        first_[kind] = ::new (memory) Block{first_[kind]};
    }

  private:
    struct Block {
        Block* next;
    };
    static std::size_t kind_of(std::size_t bytes) {
        constexpr std::size_t least = 6; // a line of a cache
        return std::max(least, static_cast<std::size_t>(std::bit_width(bytes - 1)));
    }

    std::array<Block*, 64> first_{};
    std::size_t kept_bytes_ = 0;
};

template <class T>
struct Allocator {
    using value_type = T;

    Allocator() = default;
    template <class U>
    Allocator(const Allocator<U>&) {} // NOLINT(google-explicit-constructor): as allocators are

    T* allocate(std::size_t count) {
        static_assert(alignof(T) <= __STDCPP_DEFAULT_NEW_ALIGNMENT__);
        if (count > static_cast<std::size_t>(-1) / 4 / sizeof(T))
            throw std::bad_array_new_length();
        return static_cast<T*>(Blocks::of_this_thread().take(count * sizeof(T)));
    }
    void deallocate(T* memory, std::size_t count) noexcept {
        Blocks::of_this_thread().give(memory, count * sizeof(T));
    }
    /// What has no beginning is not cleared: a vector of so many numbers holds any.
    template <class U>
    void construct(U* at) {
        ::new (at) U;
    }
    template <class U, class... Args>
    void construct(U* at, Args&&... args) {
        ::new (at) U(std::forward<Args>(args)...);
    }
    template <class U>
    bool operator==(const Allocator<U>&) const {
        return true;
    }
};

} // namespace recycled

template <class T>
using RecycledVector = std::vector<T, recycled::Allocator<T>>;

} // namespace seaway
