// SPDX-License-Identifier: Apache-2.0
#include "base/spare_memory.h"

#include <atomic>
#include <cstdint>
#include <cstring>

#include <link.h>
#include <malloc.h>
#include <sys/mman.h>
#include <unistd.h>

namespace seaway {
namespace {

/// The compiler of kernels; or a driver, each of which was asked what devices it has.
bool is_of(const dl_phdr_info& library, bool drivers) {
    return library.dlpi_name != nullptr &&
           std::strstr(library.dlpi_name, drivers ? "/libvulkan_" : "/libLLVM") != nullptr;
}

/// Of what nobody writes to: in memory there is what the file has. Tables that were relocated are not among them, since they
/// lie in a segment that is writable until then.
int give_back_code(dl_phdr_info* library, std::size_t, void* drivers_too) {
    if (!is_of(*library, false) && !(drivers_too && is_of(*library, true)))
        return 0;
    const auto page = static_cast<std::uintptr_t>(::sysconf(_SC_PAGESIZE));
    for (int i = 0; i < library->dlpi_phnum; ++i) {
        const ElfW(Phdr)& segment = library->dlpi_phdr[i];
        if (segment.p_type != PT_LOAD || (segment.p_flags & PF_W) != 0)
            continue;
        const std::uintptr_t first = (library->dlpi_addr + segment.p_vaddr) / page * page;
        const std::uintptr_t end = library->dlpi_addr + segment.p_vaddr + segment.p_memsz;
        (void)::madvise(reinterpret_cast<void*>(first), end - first, MADV_DONTNEED);
    }
    return 0;
}

/// From here on a block is the system's own: as large as malloc lets that become by itself, so that blocks that come and go stay in an arena.
constexpr int mapped_bytes_min = 32 << 20;
constexpr int arena_end_bytes_max = 1 << 20;

} // namespace

void keep_ends_of_arenas_short() {
    ::mallopt(M_MMAP_THRESHOLD, mapped_bytes_min);
    ::mallopt(M_TRIM_THRESHOLD, arena_end_bytes_max);
}

void give_back_pages(std::span<std::byte> bytes) {
    const auto page = static_cast<std::uintptr_t>(::sysconf(_SC_PAGESIZE));
    const auto begin = reinterpret_cast<std::uintptr_t>(bytes.data());
    const std::uintptr_t first = (begin + page - 1) / page * page;
    const std::uintptr_t end = (begin + bytes.size()) / page * page;
    if (end <= first)
        return;
    // Of a shared mapping (newer llvmpipe's, of a memfd) the file gives them up; a private one is refused there.
    auto* const pages = reinterpret_cast<void*>(first);
    if (::madvise(pages, end - first, MADV_REMOVE) != 0)
        (void)::madvise(pages, end - first, MADV_DONTNEED);
}

void give_back_spare_memory() {
    static std::atomic<bool> drivers_too =
        true; // once: what the one in use needs comes back for good
    ::malloc_trim(0);
    bool first = drivers_too.exchange(false);
    ::dl_iterate_phdr(give_back_code, first ? &first : nullptr);
}

} // namespace seaway
