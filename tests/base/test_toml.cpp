// SPDX-License-Identifier: Apache-2.0
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/toml_document.h"

namespace seaway {
namespace {

using ::testing::HasSubstr;

std::string error_of(const std::string& text) {
    const Result<TomlDocument> document = TomlDocument::parse(text, "a.toml");
    return document ? "it was read" : document.error().message;
}

std::string dotted(int parts) {
    std::string key = "a";
    for (int i = 1; i < parts; ++i)
        key += i % 3 == 0 ? ".a" : i % 3 == 1 ? " . \"a.a\"" : ".'a'";
    return key;
}

std::string repeated(const std::string& text, int times) {
    std::string all;
    for (int i = 0; i < times; ++i)
        all += text;
    return all;
}

// Naive: toml++ bounds brackets and no dotted key, and whoever goes through its tables level by level runs out of stack.
TEST(Toml, a_key_of_many_parts_is_refused_whatever_it_is_a_part_of) {
    EXPECT_EQ(error_of(dotted(8) + " = 1"), "it was read");
    for (const int parts : {9, 12'000, 250'000}) {
        EXPECT_EQ(error_of("\n" + dotted(parts) + " = 1"), "a.toml:2: a key of more than 8 parts");
        EXPECT_EQ(error_of("[[w]]\nset = { " + dotted(parts) + " = 1 }"),
                  "a.toml:2: a key of more than 8 parts");
        EXPECT_EQ(error_of("[" + dotted(parts) + "]"), "a.toml:1: a key of more than 8 parts");
    }
    EXPECT_EQ(error_of("a = " + repeated("[", 32) + repeated("]", 32)), "it was read");
    EXPECT_EQ(error_of("a = " + repeated("[", 33) + repeated("]", 33)),
              "a.toml:1: more than 32 brackets within each other");
    // The deepest that is read at all.
    EXPECT_EQ(error_of("a = " + repeated("{ " + dotted(8) + " = ", 32) + "1" + repeated("}", 32)),
              "it was read");
}

TEST(Toml, dots_that_part_no_key_are_not_counted) {
    EXPECT_EQ(error_of("# a.b.c.d.e.f.g.h.i.j\n"
                       "numbers = [" +
                       repeated("1.5, ", 100) +
                       "]\n"
                       "text = \"a.b.c.d.e.f.g.h.i.j\"\n"
                       "'a.b.c.d.e.f.g.h.i.j' = 1\n"
                       "long = '''\na.b.c.d.e.f.g.h.i.j\n'''\n" +
                       repeated("[[a.b.c]]\nd.e.f = 1.5 # x.y.z\n", 100)),
              "it was read");
}

// Naive: what is beyond 64 bits is read as nothing, and the first element is taken.
TEST(Toml, an_index_of_any_length_names_one_element_or_none) {
    const std::string scene = "[[sea.system]]\nwind = 8\n";
    for (const std::string index :
         {"18446744073709551616", "99999999999999999999999999", "1", "-1", "0x0", ""}) {
        const TomlAssignment assignment{"sea.system." + index + ".wind", "24"};
        const Result<std::string> set = with_toml_values(scene, "a scene", {&assignment, 1}, {});
        ASSERT_FALSE(set) << index;
        EXPECT_THAT(set.error().message, HasSubstr("there is no sea.system." + index));
    }
    const TomlAssignment first{"sea.system.0.wind", "24"};
    EXPECT_THAT(with_toml_values(scene, "a scene", {&first, 1}, {}).value(), HasSubstr("24"));
}

} // namespace
} // namespace seaway
