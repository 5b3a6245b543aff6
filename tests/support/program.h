// SPDX-License-Identifier: Apache-2.0
// Runs a program to its end and keeps what it said. Any thread.
#pragma once

#include <sys/wait.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include "tests/support/folder.h"
#include "tests/support/read_file.h"

namespace seaway::tests {

struct Output {
    int status; ///< exit status; 128 and the signal's number of what a signal ended
    std::string out;
    std::string err;
    /// Both: the errors behind the rest.
    std::string said() const { return out + err; }
    long error_lines() const { return std::count(err.begin(), err.end(), '\n'); }
};

/// `command` as a shell takes it, pipes and files of its own included; `input` goes to stdin.
inline Output run_command(const std::string& command, const std::string& input = {}) {
    const std::string in = folder().fresh("stdin"), out = folder().fresh("stdout"),
                      err = folder().fresh("stderr");
    std::ofstream(in, std::ios::binary) << input;
    const std::string line = "{ " + command + "\n} <" + in + " >" + out + " 2>" + err;
    const int status = std::system(line.c_str());
    const Output output{WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status),
                        read_file(out), read_file(err)};
    for (const std::string& file : {in, out, err})
        std::filesystem::remove(file);
    return output;
}

/// One of our programs; `first`: what the shell does before.
inline Output run_program(const std::string& name, const std::string& arguments,
                          const std::string& input = {}, const std::string& first = {}) {
    return run_command(first + " " SEAWAY_BIN_DIR "/" + name + " " + arguments, input);
}

} // namespace seaway::tests
