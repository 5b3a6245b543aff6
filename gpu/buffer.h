// SPDX-License-Identifier: Apache-2.0
// Buffer: device memory with a length, and TexelView: the same bytes as a typed, read-only array.
// One allocation a buffer: make few, keep them.
#pragma once

#include <cstddef>
#include <span>
#include <string_view>

#include "base/result.h"
#include "gpu/device.h"

namespace seaway::gpu {

enum class BufferKind {
    device,   ///< fastest for the GPU; mapped too where memory is unified
    upload,   ///< written by the CPU, read by the GPU
    readback, ///< written by the GPU, read by the CPU
};

/// Usable as storage, uniform, texel, vertex, index and indirect buffer and for copies.
class Buffer {
  public:
    Buffer() = default;
    /// `bytes` > 0. `name` is for error messages, which name the limit of the device where there
    /// is one. Contents are undefined.
    static Result<Buffer> create(Device& device, std::string_view name, std::size_t bytes,
                                 BufferKind kind);

    VkBuffer get() const { return buffer_.get(); }
    std::size_t size_bytes() const { return bytes_; }
    /// The memory itself, coherent; empty if the CPU cannot see it.
    std::span<std::byte> mapped() const { return mapped_; }
    template <class T>
    std::span<T> mapped_as() const {
        return {reinterpret_cast<T*>(mapped_.data()), mapped_.size() / sizeof(T)};
    }

  private:
    // The buffer goes before its memory: members are destroyed backwards.
    OwnedMemory memory_;
    OwnedBuffer buffer_;
    std::size_t bytes_ = 0;
    std::span<std::byte> mapped_;
};

/// Bytes of one buffer that kernels of a device may see at once, as storage and as texels of so many bytes.
std::size_t bound_bytes_max(const Device& device, std::size_t texel_bytes);

/// Copies `bytes` to the start of `buffer`: in place if it is mapped, else through a staging buffer
/// and a submission that is waited for. Nothing may be using the buffer.
Result<void> upload(Device& device, Buffer& buffer, std::span<const std::byte> bytes);

/// Copies the start of `buffer` to `bytes`, likewise.
Result<void> download(Device& device, const Buffer& buffer, std::span<std::byte> bytes);

class TexelView {
  public:
    TexelView() = default;
    /// A range of `buffer` as `format`; the error names the limit if it is too long.
    static Result<TexelView> create(Device& device, const Buffer& buffer, VkFormat format,
                                    std::size_t texel_bytes, std::size_t offset_bytes,
                                    std::size_t range_bytes);
    VkBufferView get() const { return view_.get(); }

  private:
    OwnedBufferView view_;
};

} // namespace seaway::gpu
