// SPDX-License-Identifier: Apache-2.0
// A file of options: refused with file and line, or what is read has names and words, and reads the same again;
// and the words of a command line with such a file.
#include <cstdint>
#include <cstdlib>

#include "base/command_line.h"
#include "base/options_file.h"
#include "tests/fuzz/scratch_file.h"

using namespace seaway;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const std::string path = tests::scratch_file("options.toml", data, size);
    const auto options = read_options_file(path);
    if (!options) {
        if (options.error().message.find(path) == std::string::npos)
            std::abort();
    } else {
        for (const FileOption& option : *options)
            if (option.name.empty() || option.line == 0 ||
                (option.is_bool && !option.words.empty()))
                std::abort();
        const auto again = read_options_file(path);
        if (!again || again->size() != options->size())
            std::abort();
    }
    std::string scene;
    std::vector<std::string> origins;
    int sessions = 7;
    double rate = 0.5;
    bool check = false;
    CommandLine line("fuzz", "Options of every kind.");
    line.option("scene", scene, "A place");
    line.option("--allow-origin", origins, "A list").one_at_a_time();
    line.option("--sessions-max", sessions, "A number").between(1, 1000);
    line.option("--work-rate", rate, "Another").between(0.001, 1000.0);
    line.option("--check", check, "A flag");
    line.file_of_options("--config", "A file");
    const auto next = line.read({"--config", path});
    if (next && (sessions < 1 || sessions > 1000 || !(rate >= 0.001 && rate <= 1000.0)))
        std::abort();
    if (!next && next.error().message.empty())
        std::abort();
    return 0;
}
