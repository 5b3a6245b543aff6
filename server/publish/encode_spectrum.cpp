// SPDX-License-Identifier: Apache-2.0
#include "server/publish/encode_spectrum.h"

#include <span>
#include <utility>
#include <vector>

#include "protocol/limits.h"
#include "protocol/messages.h"
#include "protocol/spectrum_codec.h"

namespace seaway::server {
namespace {

namespace limits = protocol::limits;

/// What a chunk is filled up to, by the estimate of its blocks: three or four of them are the first 10 KB.
constexpr double chunk_bits = 8.0 * 2200;

/// Blocks to messages. Compressed they are about as long as estimated; one that is too long is made two.
class Chunks {
  public:
    Chunks(std::uint32_t epoch, const sea::QuantisedSpectrum& waves)
        : epoch_(epoch), waves_(waves) {
        double bits = 0;
        std::size_t first = 0;
        for (std::size_t b = 0; b < waves.blocks.size(); ++b) {
            bits += waves.bits[b];
            const std::size_t count = b + 1 - first;
            if (bits < chunk_bits && count < limits::spectrum_blocks_max &&
                b + 1 < waves.blocks.size())
                continue;
            add(first, count);
            first = b + 1;
            bits = 0;
        }
    }

    std::vector<EncodedSpectrum::Message> messages;
    std::size_t payload_bytes = 0;

  private:
    void add(std::size_t first, std::size_t count) {
        const protocol::Bytes payload =
            protocol::encode_spectrum(std::span(waves_.blocks).subspan(first, count));
        if (payload.size() > limits::spectrum_chunk_bytes_max) {
            add(first, count / 2);
            return add(first + count / 2, count - count / 2);
        }
        payload_bytes += payload.size();
        messages.push_back(std::make_shared<const protocol::Bytes>(
            protocol::spectrum_chunk(epoch_, static_cast<std::uint32_t>(messages.size()),
                                     waves_.left[first + count - 1], payload)));
    }

    const std::uint32_t epoch_;
    const sea::QuantisedSpectrum& waves_;
};

} // namespace

std::unique_ptr<EncodedSpectrum> encode_spectrum(const SpectrumSource& sea,
                                                 const sea::QuantisedSpectrum& waves) {
    Chunks chunks(sea.epoch, waves);
    if (chunks.payload_bytes > limits::spectrum_bytes_max ||
        chunks.messages.size() > limits::spectrum_chunks_max)
        return nullptr;
    auto encoded = std::make_unique<EncodedSpectrum>();
    encoded->epoch = sea.epoch;
    encoded->ends_epoch = sea.ends_epoch;
    encoded->whole_by_us = sea.whole_by_us;
    encoded->messages.push_back(std::make_shared<const protocol::Bytes>(
        protocol::spectrum({.epoch = sea.epoch,
                            .chunks = static_cast<std::uint32_t>(chunks.messages.size()),
                            .bytes = static_cast<std::uint32_t>(chunks.payload_bytes),
                            .steps = waves.steps,
                            .dispersion = sea.dispersion,
                            .loop_period_us = sea.waves->loop_period_us})));
    for (EncodedSpectrum::Message& message : chunks.messages)
        encoded->messages.push_back(std::move(message));
    for (const EncodedSpectrum::Message& message : encoded->messages)
        encoded->bytes += message->size();
    return encoded;
}

} // namespace seaway::server
