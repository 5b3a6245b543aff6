// SPDX-License-Identifier: Apache-2.0
// Bytes that were written once and are read for ever: a message of every kind, a tile of every mode
// (tests/golden/README.md).
#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>

#include <flatbuffers/minireflect.h>
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "protocol/tile_codec.h"
#include "protocol/tile_layout.h"
#include "tests/protocol/sample_messages.h"

namespace seaway::protocol {
namespace {

const std::filesystem::path golden_folder =
    std::filesystem::path(SEAWAY_SOURCE_DIR) / "tests/golden";

/// A golden: "# ..." lines of people, lines of bytes in hexadecimal, and after "says" its values.
struct Golden {
    Bytes bytes;
    std::vector<std::string> values;
};

Golden read_golden(const std::string& name) {
    Golden golden;
    std::ifstream file(golden_folder / name);
    bool says = false;
    for (std::string line; std::getline(file, line);) {
        if (line.empty() || line.starts_with('#'))
            continue;
        if (line == "says") {
            says = true;
        } else if (says) {
            golden.values.push_back(line);
        } else {
            std::istringstream hex(line);
            for (std::string byte; hex >> byte;)
                golden.bytes.push_back(static_cast<std::uint8_t>(std::stoi(byte, nullptr, 16)));
        }
    }
    return golden;
}

std::string golden_text(std::span<const std::uint8_t> bytes,
                        const std::vector<std::string>& values) {
    std::string text;
    for (std::size_t i = 0; i < bytes.size(); ++i)
        text +=
            fmt::format("{:02x}{}", bytes[i], i % 16 == 15 || i + 1 == bytes.size() ? '\n' : ' ');
    text += "says\n";
    for (const std::string& value : values)
        text += value + "\n";
    return text;
}

/// Every value of a message, one line each: "points.1.y_m = 2000000". Walks the schema's own tables,
/// so that no kind and no field can be forgotten.
class Values : public flatbuffers::IterationVisitor {
  public:
    std::vector<std::string> lines;

    void StartSequence() override { path_.emplace_back(); }
    void EndSequence() override { path_.pop_back(); }
    void Field(std::size_t, std::size_t, flatbuffers::ElementaryType, bool,
               const flatbuffers::TypeTable*, const char* name, const std::uint8_t*) override {
        path_.back() = name;
    }
    void StartVector() override { path_.emplace_back(); }
    void EndVector() override { path_.pop_back(); }
    void Element(std::size_t i, flatbuffers::ElementaryType, const flatbuffers::TypeTable*,
                 const std::uint8_t*) override {
        path_.back() = std::to_string(i);
    }
    void UType(std::uint8_t x, const char*) override { add(x); }
    void Bool(bool x) override { add(x); }
    void Char(std::int8_t x, const char*) override { add(x); }
    void UChar(std::uint8_t x, const char*) override { add(x); }
    void Short(std::int16_t x, const char*) override { add(x); }
    void UShort(std::uint16_t x, const char*) override { add(x); }
    void Int(std::int32_t x, const char*) override { add(x); }
    void UInt(std::uint32_t x, const char*) override { add(x); }
    void Long(std::int64_t x) override { add(x); }
    void ULong(std::uint64_t x) override { add(x); }
    void Float(float x) override { add(x); }
    void Double(double x) override { add(x); }
    void String(const flatbuffers::String* x) override { add('"' + one_line(x->str()) + '"'); }
    void Unknown(const std::uint8_t*) override { add("?"); }

  private:
    static std::string one_line(std::string text) {
        for (std::size_t at = 0; (at = text.find('\n', at)) != std::string::npos; at += 2)
            text.replace(at, 1, "\\n");
        return text;
    }
    template <class T>
    void add(const T& value) {
        lines.push_back(fmt::format("{} = {}", fmt::join(path_, "."), value));
    }
    std::vector<std::string> path_;
};

std::vector<std::string> values_of(const Bytes& message) {
    Values values;
    flatbuffers::IterateFlatBuffer(message.data(), wire::MessageTypeTable(), &values);
    return values.lines;
}

TEST(Golden, every_kind_of_message_of_version_1_is_read_for_ever) {
    for (const MessageInfo& row : message_table) {
        const std::string name = fmt::format("wire_v1/{}.txt", wire::EnumNameBody(row.body));
        const Golden golden = read_golden(name);
        if (golden.bytes.empty()) {
            const Bytes bytes = tests::sample(row.body);
            ADD_FAILURE() << "tests/golden/" << name
                          << " is missing; made of today's sample it is\n"
                          << golden_text(bytes, values_of(bytes));
            continue;
        }
        MessageReader reader(row.sender);
        const auto message = reader.read(golden.bytes);
        ASSERT_TRUE(message.has_value()) << name << ": " << message.error().message;
        EXPECT_EQ((*message)->body_type(), row.body) << name;
        EXPECT_TRUE(check(**message).has_value()) << name;
        EXPECT_EQ(values_of(golden.bytes), golden.values) << name;
    }
}

// What is written today says all that the golden says, in the same places; it may say more, in
// fields that the schema has been given since.
TEST(Golden, every_kind_of_message_is_written_with_all_that_its_golden_says) {
    for (const MessageInfo& row : message_table) {
        const std::vector<std::string> today = values_of(tests::sample(row.body));
        auto at = today.begin();
        for (const std::string& value :
             read_golden(fmt::format("wire_v1/{}.txt", wire::EnumNameBody(row.body))).values) {
            at = std::find(at, today.end(), value);
            ASSERT_NE(at, today.end()) << wire::EnumNameBody(row.body) << " lacks " << value;
        }
    }
}

constexpr TileShape golden_shape{4, 3};
constexpr tile_layout::Mode modes[] = {tile_layout::Mode::constant, tile_layout::Mode::quantised,
                                       tile_layout::Mode::lossless, tile_layout::Mode::difference};

/// No default: a new mode does not compile without its golden.
const char* name_of(tile_layout::Mode mode) {
    switch (mode) {
    case tile_layout::Mode::constant:
        return "constant";
    case tile_layout::Mode::quantised:
        return "quantised";
    case tile_layout::Mode::lossless:
        return "lossless";
    case tile_layout::Mode::difference:
        return "difference";
    }
    return "";
}

std::vector<float> golden_samples(tile_layout::Mode mode) {
    if (mode == tile_layout::Mode::constant)
        return std::vector<float>(12, -0.75f);
    return {0.5f, 1.0f, 1.5f, 2.0f, 0.0f, 0.5f, 1.0f, 1.5f, 0.5f, 1.0f, 1.75f, -2.0f};
}

std::vector<std::string> float_bits(std::span<const float> values) {
    std::vector<std::string> bits;
    for (const float value : values)
        bits.push_back(fmt::format("{:08x}", std::bit_cast<std::uint32_t>(value)));
    return bits;
}

/// What is expected of the golden samples where a difference is made: up to two bounds off.
std::vector<float> golden_expected() {
    return {0.5f, 0.9f, 1.5f, 1.7f, 0.1f, 0.5f, 0.625f, 1.5f, 0.5f, 1.0f, 1.75f, -2.0f};
}

Result<Bytes> encode_golden(tile_layout::Mode mode) {
    const bool loses = mode != tile_layout::Mode::constant && mode != tile_layout::Mode::lossless;
    const float error = loses ? 0.25f : 0.0f;
    if (mode != tile_layout::Mode::difference)
        return encode_tile(golden_samples(mode), golden_shape, 4, error);
    std::vector<float> decoded(12);
    SEAWAY_TRY_LET(TileForms forms, encode_tile_forms(golden_samples(mode), golden_shape, 4, error,
                                                      golden_expected(), decoded));
    return forms.difference;
}

TEST(Golden, tiles_of_every_mode_of_codec_1_decode_to_the_same_floats_for_ever) {
    for (const tile_layout::Mode mode : modes) {
        const std::string name = fmt::format("tile_codec_v1/{}.txt", name_of(mode));
        const Golden golden = read_golden(name);
        const auto today = encode_golden(mode);
        ASSERT_TRUE(today);
        const bool missing = golden.bytes.empty();
        std::vector<float> back(12);
        const Bytes& bytes = missing ? *today : golden.bytes;
        ASSERT_TRUE(mode == tile_layout::Mode::difference
                        ? decode_tile_difference(bytes, golden_shape, 4, golden_expected(), back)
                        : decode_tile(bytes, golden_shape, 4, back))
            << name;
        if (missing) {
            ADD_FAILURE() << "tests/golden/" << name << " is missing; made today it is\n"
                          << golden_text(*today, float_bits(back));
            continue;
        }
        EXPECT_EQ(golden.bytes[1], static_cast<std::uint8_t>(mode));
        EXPECT_EQ(float_bits(back), golden.values) << name;
        // Another version of zstd may write another frame; what is ours is the same bytes everywhere.
        EXPECT_TRUE(std::equal(today->begin(), today->begin() + 12, golden.bytes.begin())) << name;
    }
}

} // namespace
} // namespace seaway::protocol
