// SPDX-License-Identifier: Apache-2.0
// Runs one of our programs and keeps what it said.
#pragma once

#include <sys/wait.h>

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "tests/support/folder.h"

namespace seaway::testing {

using tests::folder;

inline std::string read_file(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

struct Output {
    int status;
    std::string out;
    std::string err;
    long error_lines() const { return std::count(err.begin(), err.end(), '\n'); }
};

/// `arguments` as a shell takes them; `input` goes to stdin; `first`: what the shell does before. Any thread.
inline Output run_program(const std::string& name, const std::string& arguments,
                          const std::string& input = {}, const std::string& first = {}) {
    static std::atomic<int> runs = 0;
    const std::string run = std::to_string(++runs);
    const std::string in = folder().write("stdin" + run, input);
    const std::string out = folder().file("stdout" + run);
    const std::string err = folder().file("stderr" + run);
    const std::string command = first + " " + SEAWAY_BIN_DIR + "/" + name + " " + arguments + " <" +
                                in + " >" + out + " 2>" + err;
    const int status = std::system(command.c_str());
    const Output output{WIFEXITED(status) ? WEXITSTATUS(status) : -1, read_file(out),
                        read_file(err)};
    for (const std::string& file : {in, out, err})
        std::filesystem::remove(file);
    return output;
}

} // namespace seaway::testing
