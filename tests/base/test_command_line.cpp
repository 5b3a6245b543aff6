// SPDX-License-Identifier: Apache-2.0
#include "base/command_line.h"

#include <cstdint>
#include <initializer_list>
#include <regex>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/folder.h"

namespace seaway {
namespace {

struct Values {
    std::string scene;
    int frames = 7;
    double time_s = 1.5;
    std::uint64_t seed = 3;
    bool quick = false;
    std::vector<int> sizes{128, 256};
    std::string form = "text";
};

Result<CommandLine::Next> read(Values& values, const std::vector<std::string>& words) {
    CommandLine line("program", "Does something.");
    line.option("scene", values.scene).required();
    line.option("--frames", values.frames).between(1, 10);
    const CommandOption time = line.option("--time", values.time_s).between(-1e9, 1e9);
    line.option("--seed", values.seed).needs(time);
    line.option("--quick", values.quick).excludes(time);
    line.option("--sizes", values.sizes).separated_by(',').one_of({64, 128, 256});
    line.option("--form", values.form).one_of({"text", "json"});
    line.file_of_options("--config", "Options");
    return line.read(words);
}

TEST(CommandLine, words_become_values_and_what_is_not_given_stays) {
    Values values;
    const auto next = read(values, {"a.toml", "--time", "-2e3", "--seed", "18446744073709551615",
                                    "--sizes", "64,256"});
    ASSERT_TRUE(next) << next.error().message;
    EXPECT_EQ(*next, CommandLine::Next::go_on);
    EXPECT_EQ(values.scene, "a.toml");
    EXPECT_EQ(values.time_s, -2e3);
    EXPECT_EQ(values.seed, ~std::uint64_t{0});
    EXPECT_EQ(values.sizes, (std::vector<int>{64, 256}));
    EXPECT_EQ(values.frames, 7);
    EXPECT_FALSE(values.quick);
    EXPECT_EQ(values.form, "text");
}

TEST(CommandLine, what_is_wrong_is_one_line_that_names_the_option) {
    const struct {
        std::vector<std::string> words;
        std::string named;
    } cases[] = {{{}, "scene"},
                 {{"a", "b"}, "b"},
                 {{"a", "--frames", "0"}, "--frames"},
                 {{"a", "--frames", "11"}, "--frames"},
                 {{"a", "--frames", "2.5"}, "--frames"},
                 {{"a", "--frames"}, "--frames"},
                 {{"a", "--time", "2e9"}, "--time"},
                 {{"a", "--time", "nan"}, "'nan' is not a number -1e+09 .. 1e+09"},
                 {{"a", "--form", ""}, "--form"},
                 {{""}, "scene"},
                 {{"a", "--seed", "1"}, "--time"},
                 {{"a", "--quick", "--time", "1"}, "--quick"},
                 {{"a", "--sizes", "64,65"}, "65"},
                 {{"a", "--form", "csv"}, "csv"},
                 {{"a", "--nothing"}, "--nothing"}};
    for (const auto& [words, named] : cases) {
        Values values;
        const auto next = read(values, words);
        ASSERT_FALSE(next) << named;
        EXPECT_NE(next.error().message.find(named), std::string::npos) << next.error().message;
        EXPECT_EQ(next.error().message.find('\n'), std::string::npos) << next.error().message;
    }
}

// Naive: the parser has the words alone, and whoever is told looks for them where he has not written them.
TEST(CommandLine, a_value_of_a_file_that_is_refused_is_named_with_file_and_line) {
    const struct {
        std::string text, name, why;
    } cases[] = {{"frames = 11", "frames", "11"},
                 {"frames = 2.5", "frames", "2.5"},
                 {"frames = \"many\"", "frames", "many"},
                 {"time = 2e9", "time", "'2000000000' is not a number -1e+09 .. 1e+09"},
                 {"time = \"x\"", "time", "'x' is not a number -1e+09 .. 1e+09"},
                 {"seed = \"x\"\ntime = 1", "seed", "x"},
                 {"seed = 1", "seed", "requires --time"},
                 {"sizes = [128,\n65]", "sizes", "65"},
                 {"form = \"csv\"", "form", "csv"}};
    for (const auto& [text, name, why] : cases) {
        const std::string file = tests::folder().write("refused.toml", "# of\n" + text + "\n");
        Values values;
        const auto next = read(values, {"a", "--config", file});
        ASSERT_FALSE(next) << text;
        const std::string& said = next.error().message;
        EXPECT_TRUE(said.starts_with(file + ":2: " + name + ": ")) << said;
        EXPECT_NE(said.find(why, file.size()), std::string::npos) << said;
        EXPECT_EQ(said.find("--" + name + ": "), std::string::npos) << "its name once: " << said;
    }
}

TEST(CommandLine, a_value_of_the_line_that_is_refused_is_not_of_the_file) {
    const std::string file = tests::folder().write("fine.toml", "frames = 3\nform = \"json\"\n");
    for (const std::vector<std::string>& words : std::initializer_list<std::vector<std::string>>{
             {"a", "--config", file, "--frames", "11"},
             {"a", "--config", file, "--time", "2e9"},
             {"a", "--config", file, "--time", "--form x"}}) {
        Values values;
        const auto next = read(values, words);
        ASSERT_FALSE(next);
        EXPECT_EQ(next.error().message.find(file), std::string::npos) << next.error().message;
    }
}

TEST(CommandLine, the_ends_of_a_range_belong_to_it) {
    for (const auto& [option, ends] : {std::pair("--frames", std::pair("1", "10")),
                                       std::pair("--time", std::pair("-1e9", "1e9"))})
        for (const char* end : {ends.first, ends.second}) {
            Values values;
            const auto next = read(values, {"a", option, end});
            EXPECT_TRUE(next) << option << ' ' << end;
        }
    Values values;
    EXPECT_FALSE(read(values, {"a", "--time", "1.0000001e9"}));
    EXPECT_FALSE(read(values, {"a", "--time", "-1.0000001e9"}));
}

TEST(CommandLine, help_and_version_are_printed_and_nothing_is_left_to_do) {
    for (const std::string word : {"--help", "--version"}) {
        Values values;
        testing::internal::CaptureStdout();
        const auto next = read(values, {word});
        const std::string printed = testing::internal::GetCapturedStdout();
        ASSERT_TRUE(next) << next.error().message;
        EXPECT_EQ(*next, CommandLine::Next::leave);
        EXPECT_NE(printed.find("program"), std::string::npos) << printed;
    }
}

TEST(CommandLine, a_default_is_shown_with_all_of_its_digits) {
    CommandLine line("program", "Does something.");
    double bytes = 33'554'432, share = 0.1;
    line.option("--bytes", bytes, "so many").shows_default();
    line.option("--share", share, "of it").shows_default();
    ::testing::internal::CaptureStdout();
    ASSERT_TRUE(line.read({"--help"}));
    const std::string help = ::testing::internal::GetCapturedStdout();
    // "FLOAT=0.1" or, by later CLI11, "FLOAT [0.1]".
    EXPECT_TRUE(std::regex_search(help, std::regex("[=\\[]33554432[\\] ]"))) << help;
    EXPECT_TRUE(std::regex_search(help, std::regex("[=\\[]0\\.1[\\] ]"))) << help;
}

TEST(CommandLine, one_of_its_commands_has_to_be_given) {
    int frames = 0;
    CommandLine line("program", "Does something.");
    CommandLine& first = line.command("first", "One thing.");
    first.option("--frames", frames);
    CommandLine& second = line.command("second", "Another.");
    const auto says = [&](std::vector<std::string> words, const std::string& what) {
        const auto wrong = line.read(std::move(words));
        EXPECT_FALSE(wrong);
        EXPECT_EQ(wrong ? "" : wrong.error().message, what);
    };
    says({}, "a command is missing: first, second");
    says({"frist", "--frames", "3"}, "'frist' is none of its commands; the nearest is first");
    says({"secondly"}, "'secondly' is none of its commands; the nearest is second");
    says({"elsewhere"}, "'elsewhere' is none of its commands");
    ASSERT_TRUE(line.read({"first", "--frames", "3"}));
    EXPECT_TRUE(first.given());
    EXPECT_FALSE(second.given());
    EXPECT_EQ(frames, 3);
}

// Naive: the word stands where an address is expected, and the page of the whole program comes, which has none of its options.
TEST(CommandLine, help_of_a_command_is_had_by_its_name_alone) {
    std::string url;
    int frames = 0;
    CommandLine line("program", "Does something.");
    line.option("url", url, "Where").required();
    line.command("first", "One thing.").option("--frames", frames, "how many");
    for (const char* help : {"--help", "-h"}) {
        ::testing::internal::CaptureStdout();
        const auto next = line.read({"first", help});
        const std::string printed = ::testing::internal::GetCapturedStdout();
        ASSERT_TRUE(next) << next.error().message;
        EXPECT_EQ(*next, CommandLine::Next::leave);
        EXPECT_NE(printed.find("--frames"), std::string::npos) << printed;
    }
}

// As seaway-ctl has it: the word behind the address is a command.
TEST(CommandLine, a_word_that_is_no_command_is_named_with_the_nearest_wherever_it_stands) {
    std::string url, file;
    CommandLine line("program", "Does something.");
    line.option("url", url, "Where").required();
    line.option("--token-file", file, "A file");
    line.command("state", "What there is");
    line.command("sessions", "Who is there");
    for (const std::vector<std::string>& words : std::initializer_list<std::vector<std::string>>{
             {"ws://sea", "stat"},
             {"ws://sea", "--token-file", "a", "stat"},
             {"--token-file", "a", "ws://sea", "stat", "more", "--over", "3"}}) {
        const auto wrong = line.read(words);
        ASSERT_FALSE(wrong);
        EXPECT_EQ(wrong.error().message, "'stat' is none of its commands; the nearest is state");
    }
    const auto none = line.read({"ws://sea"});
    ASSERT_FALSE(none);
    EXPECT_EQ(none.error().message, "a command is missing: state, sessions");
}

/// A program with an option of each kind and a command; what it writes of itself.
std::string written(const std::string& word) {
    std::string scene;
    std::string form = "text";
    std::string secret;
    CommandLine line("seaway-thing", "Does something. And more.\n.Not a request");
    line.option("scene", scene, "What is looked at").required().takes("SCENE.toml");
    line.option("--form", form, "How it is written").takes("NAME|all").one_of({"text", "json"});
    CommandLine& drop = line.command("drop", "Ends a thing");
    drop.option("--token-file", secret, "A file").takes("FILE");
    testing::internal::CaptureStdout();
    const auto next = line.read({word});
    EXPECT_TRUE(next && *next == CommandLine::Next::leave);
    return testing::internal::GetCapturedStdout();
}

TEST(CommandLine, a_page_of_the_manual_says_what_the_help_says_and_no_text_is_a_request) {
    const std::string page = written("--manual");
    for (const char* part :
         {".TH SEAWAY\\-THING 1", "seaway\\-thing \\- does something\n",
          "[OPTIONS] scene COMMAND ...", "\n\\&.Not a request", "What is looked at",
          "\\-\\-form NAME|all", ".SS drop [OPTIONS]", "\\-\\-token\\-file FILE"})
        EXPECT_NE(page.find(part), std::string::npos) << part << " in\n" << page;
}

TEST(CommandLine, completion_offers_words_where_words_are_taken_and_files_where_files_are) {
    const std::string script = written("--completion");
    for (const char* part :
         {" :--form) words='all text json' paths=0", " drop:--token-file) words='' paths=1",
          " :*) words='drop' paths=1", "words='-h --help --version --form' paths=0",
          "complete -o filenames -F _seaway_thing seaway-thing\n"})
        EXPECT_NE(script.find(part), std::string::npos) << part << " in\n" << script;
}

} // namespace
} // namespace seaway
