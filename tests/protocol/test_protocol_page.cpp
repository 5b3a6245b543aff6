// SPDX-License-Identifier: Apache-2.0
// docs/protocol.md, from which clients in other languages are written, lists every field, message
// and code with its number, as the tables of the code and the schema do.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "protocol/limits.h"
#include "protocol/messages.h"
#include "tests/support/read_file.h"
#include "tests/support/times_in.h"

namespace seaway::protocol {
namespace {

std::string page() {
    return seaway::tests::read_file(SEAWAY_SOURCE_DIR "/docs/protocol.md");
}

/// Lines of the page that begin so.
int rows(const std::string& text, const std::string& begin) {
    return seaway::tests::times_in(text, "\n" + begin);
}

TEST(ProtocolPage, ends_with_the_schema_as_it_is) {
    const std::string schema = seaway::tests::read_file(SEAWAY_SOURCE_DIR "/protocol/seaway.fbs");
    EXPECT_NE(page().find("```fbs\n" + schema + "```\n"), std::string::npos)
        << "copy protocol/seaway.fbs to the end of docs/protocol.md";
}

TEST(ProtocolPage, lists_number_name_and_unit_of_every_field) {
    const std::string text = page();
    for (const sea::FieldInfo& row : sea::field_table)
        EXPECT_EQ(
            rows(text, fmt::format("| {} | `{}` | {} | {} |", static_cast<int>(row.field), row.name,
                                   row.unit, row.kind == sea::Kind::linear ? "yes" : "no")),
            1)
            << row.name;
}

TEST(ProtocolPage, lists_number_name_and_sender_of_every_message) {
    const std::string text = page();
    for (const MessageInfo& row : message_table)
        EXPECT_EQ(rows(text, fmt::format("| {} | `{}` | {} |", static_cast<int>(row.body),
                                         wire::EnumNameBody(row.body),
                                         row.sender == Sender::client ? "client" : "server")),
                  1)
            << wire::EnumNameBody(row.body);
}

TEST(ProtocolPage, lists_every_code_with_its_close_code) {
    const std::string text = page();
    for (const wire::ErrorCode code : wire::EnumValuesErrorCode())
        EXPECT_EQ(rows(text, fmt::format("| {} | {} | {} |", static_cast<int>(code),
                                         close_code(code), name(code))),
                  1)
            << name(code);
}

TEST(ProtocolPage, lists_every_flag_of_an_answer) {
    const std::string text = page();
    for (std::size_t bit = 0; bit < sea::answer_flag_names.size(); ++bit) {
        const bool of_servers =
            ((sea::answer_stale | sea::answer_foam_late) >> bit & 1u) == 0; // clients set those
        EXPECT_EQ(rows(text, fmt::format("| {} | {} |", 1u << bit, sea::answer_flag_names[bit])),
                  of_servers ? 1 : 0);
    }
}

TEST(Schema, has_every_field_under_its_number_and_name) {
    EXPECT_EQ(static_cast<int>(wire::Field::MAX), sea::field_count - 1);
    for (const sea::FieldInfo& row : sea::field_table)
        EXPECT_EQ(wire::EnumNameField(static_cast<wire::Field>(row.field)), row.name);
}

} // namespace
} // namespace seaway::protocol
