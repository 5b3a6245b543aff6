// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/codec_contenders.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include <ImathBox.h>
#include <ImfArray.h>
#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfInputFile.h>
#include <ImfOutputFile.h>
#include <half.h>
#include <zstd.h>

#include "base/check.h"
#include "protocol/tile_codec.h"

#ifdef SEAWAY_HAS_ZFP
#include <zfp.h>
#endif
#ifdef SEAWAY_HAS_JXL
#include <jxl/decode.h>
#include <jxl/encode.h>
#endif

namespace seaway::bench {
namespace {

using Bytes = std::vector<std::uint8_t>;
using Map = std::vector<float>;

std::size_t samples(int size) {
    return static_cast<std::size_t>(size) * static_cast<std::size_t>(size);
}

Codec own() {
    return {
        "own",
        [](std::span<const float> map, int size, float error) {
            return *protocol::encode_tile(map, {size, size}, static_cast<std::size_t>(size), error);
        },
        [](std::span<const std::uint8_t> bytes, int size, float) {
            Map map(samples(size));
            SEAWAY_CHECK(
                protocol::decode_tile(bytes, {size, size}, static_cast<std::size_t>(size), map)
                    .has_value(),
                "what was encoded is decoded");
            return map;
        }};
}

Bytes compressed(std::span<const std::uint8_t> bytes) {
    Bytes out(ZSTD_compressBound(bytes.size()));
    out.resize(ZSTD_compress(out.data(), out.size(), bytes.data(), bytes.size(), 3));
    return out;
}

/// Half precision, low bytes before high ones, zstd level 3.
Codec half_zstd() {
    return {"fp16 + zstd",
            [](std::span<const float> map, int, float) {
                Bytes planes(2 * map.size());
                for (std::size_t i = 0; i < map.size(); ++i) {
                    const std::uint16_t bits = Imath::half(map[i]).bits();
                    planes[i] = static_cast<std::uint8_t>(bits);
                    planes[map.size() + i] = static_cast<std::uint8_t>(bits >> 8);
                }
                return compressed(planes);
            },
            [](std::span<const std::uint8_t> bytes, int size, float) {
                Bytes planes(2 * samples(size));
                ZSTD_decompress(planes.data(), planes.size(), bytes.data(), bytes.size());
                Map map(samples(size));
                for (std::size_t i = 0; i < map.size(); ++i) {
                    Imath::half value;
                    value.setBits(
                        static_cast<std::uint16_t>(planes[i] | planes[map.size() + i] << 8));
                    map[i] = value;
                }
                return map;
            }};
}

class MemoryOut final : public Imf::OStream {
  public:
    MemoryOut() : OStream("memory") {}
    void write(const char* bytes, int count) override {
        bytes_.resize(std::max(bytes_.size(), at_ + static_cast<std::size_t>(count)));
        std::memcpy(bytes_.data() + at_, bytes, static_cast<std::size_t>(count));
        at_ += static_cast<std::size_t>(count);
    }
    std::uint64_t tellp() override { return at_; }
    void seekp(std::uint64_t to) override { at_ = to; }
    Bytes take() { return std::move(bytes_); }

  private:
    Bytes bytes_;
    std::size_t at_ = 0;
};

class MemoryIn final : public Imf::IStream {
  public:
    explicit MemoryIn(std::span<const std::uint8_t> bytes) : IStream("memory"), bytes_(bytes) {}
    bool read(char* bytes, int count) override {
        std::memcpy(bytes, bytes_.data() + at_, static_cast<std::size_t>(count));
        at_ += static_cast<std::size_t>(count);
        return at_ < bytes_.size();
    }
    std::uint64_t tellg() override { return at_; }
    void seekg(std::uint64_t to) override { at_ = to; }

  private:
    std::span<const std::uint8_t> bytes_;
    std::size_t at_ = 0;
};

Imf::FrameBuffer frame_of(std::vector<Imath::half>& halves, int size) {
    Imf::FrameBuffer frame;
    const auto stride = sizeof(Imath::half);
    frame.insert("Z", Imf::Slice(Imf::HALF, reinterpret_cast<char*>(halves.data()), stride,
                                 stride * static_cast<std::size_t>(size)));
    return frame;
}

Codec piz() {
    return {"OpenEXR PIZ half",
            [](std::span<const float> map, int size, float) {
                std::vector<Imath::half> halves(map.begin(), map.end());
                Imf::Header header(size, size);
                header.compression() = Imf::PIZ_COMPRESSION;
                header.channels().insert("Z", Imf::Channel(Imf::HALF));
                MemoryOut out;
                {
                    Imf::OutputFile file(out, header, 0);
                    file.setFrameBuffer(frame_of(halves, size));
                    file.writePixels(size);
                }
                return out.take();
            },
            [](std::span<const std::uint8_t> bytes, int size, float) {
                std::vector<Imath::half> halves(samples(size));
                MemoryIn in(bytes);
                Imf::InputFile file(in, 0);
                file.setFrameBuffer(frame_of(halves, size));
                file.readPixels(0, size - 1);
                return Map(halves.begin(), halves.end());
            }};
}

#ifdef SEAWAY_HAS_ZFP
/// In accuracy mode, whose tolerance is a bound.
Codec zfp() {
    const auto with_stream = [](void* values, int size, float error, Bytes& bytes,
                                const auto& use) {
        const auto side = static_cast<std::size_t>(size);
        zfp_field* field = zfp_field_2d(values, zfp_type_float, side, side);
        zfp_stream* stream = zfp_stream_open(nullptr);
        zfp_stream_set_accuracy(stream, static_cast<double>(error));
        if (bytes.empty())
            bytes.resize(zfp_stream_maximum_size(stream, field));
        bitstream* bits = stream_open(bytes.data(), bytes.size());
        zfp_stream_set_bit_stream(stream, bits);
        zfp_stream_rewind(stream);
        const std::size_t count = use(stream, field);
        stream_close(bits);
        zfp_stream_close(stream);
        zfp_field_free(field);
        return count;
    };
    return {"zfp",
            [with_stream](std::span<const float> map, int size, float error) {
                Map values(map.begin(), map.end());
                Bytes bytes;
                bytes.resize(with_stream(values.data(), size, error, bytes, zfp_compress));
                return bytes;
            },
            [with_stream](std::span<const std::uint8_t> bytes, int size, float error) {
                Map values(samples(size));
                Bytes padded(bytes.begin(), bytes.end()); // it reads whole words
                padded.resize(bytes.size() + 64);
                SEAWAY_CHECK(with_stream(values.data(), size, error, padded, zfp_decompress) > 0,
                             "what was encoded is decoded");
                return values;
            }};
}
#endif

#ifdef SEAWAY_HAS_JXL
constexpr std::int32_t middle = 1 << 15;
constexpr JxlPixelFormat format{1, JXL_TYPE_UINT16, JXL_LITTLE_ENDIAN, 0};

/// The integers that our codec sends, as a grey picture without loss.
Codec jxl(int effort) {
    const auto encode = [effort](std::span<const float> map, int size, float error) {
        std::vector<std::uint16_t> grey(map.size());
        for (std::size_t i = 0; i < map.size(); ++i)
            grey[i] = static_cast<std::uint16_t>(std::lround(map[i] / (2 * error)) + middle);
        JxlEncoder* encoder = JxlEncoderCreate(nullptr);
        JxlBasicInfo info;
        JxlEncoderInitBasicInfo(&info);
        info.xsize = info.ysize = static_cast<std::uint32_t>(size);
        info.bits_per_sample = 16;
        info.num_color_channels = 1;
        info.uses_original_profile = JXL_TRUE;
        JxlColorEncoding colour;
        JxlColorEncodingSetToSRGB(&colour, JXL_TRUE);
        JxlEncoderFrameSettings* frame = JxlEncoderFrameSettingsCreate(encoder, nullptr);
        SEAWAY_CHECK(
            JxlEncoderSetBasicInfo(encoder, &info) == JXL_ENC_SUCCESS &&
                JxlEncoderSetColorEncoding(encoder, &colour) == JXL_ENC_SUCCESS &&
                JxlEncoderSetFrameLossless(frame, JXL_TRUE) == JXL_ENC_SUCCESS &&
                JxlEncoderFrameSettingsSetOption(frame, JXL_ENC_FRAME_SETTING_EFFORT, effort) ==
                    JXL_ENC_SUCCESS &&
                JxlEncoderAddImageFrame(frame, &format, grey.data(),
                                        grey.size() * sizeof(std::uint16_t)) == JXL_ENC_SUCCESS,
            "a grey picture of 16 bits can be encoded");
        JxlEncoderCloseInput(encoder);
        Bytes bytes(map.size() * 4 + 4096);
        std::uint8_t* next = bytes.data();
        std::size_t left = bytes.size();
        SEAWAY_CHECK(JxlEncoderProcessOutput(encoder, &next, &left) == JXL_ENC_SUCCESS,
                     "the buffer is large enough");
        JxlEncoderDestroy(encoder);
        bytes.resize(bytes.size() - left);
        return bytes;
    };
    const auto decode = [](std::span<const std::uint8_t> bytes, int size, float error) {
        std::vector<std::uint16_t> grey(samples(size));
        JxlDecoder* decoder = JxlDecoderCreate(nullptr);
        JxlDecoderSubscribeEvents(decoder, JXL_DEC_FULL_IMAGE);
        JxlDecoderSetInput(decoder, bytes.data(), bytes.size());
        JxlDecoderCloseInput(decoder);
        JxlDecoderStatus status = JxlDecoderProcessInput(decoder);
        while (status == JXL_DEC_NEED_IMAGE_OUT_BUFFER) {
            JxlDecoderSetImageOutBuffer(decoder, &format, grey.data(),
                                        grey.size() * sizeof(std::uint16_t));
            status = JxlDecoderProcessInput(decoder);
        }
        SEAWAY_CHECK(status == JXL_DEC_FULL_IMAGE || status == JXL_DEC_SUCCESS,
                     "what was encoded is decoded");
        JxlDecoderDestroy(decoder);
        Map map(grey.size());
        for (std::size_t i = 0; i < map.size(); ++i)
            map[i] = static_cast<float>(grey[i] - middle) * 2 * error;
        return map;
    };
    return {"libjxl lossless, effort " + std::to_string(effort), encode, decode};
}
#endif

} // namespace

std::vector<Codec> codecs() {
    std::vector<Codec> all{own(), half_zstd(), piz()};
#ifdef SEAWAY_HAS_ZFP
    all.push_back(zfp());
#endif
#ifdef SEAWAY_HAS_JXL
    all.push_back(jxl(1));
    all.push_back(jxl(3));
#endif
    return all;
}

} // namespace seaway::bench
