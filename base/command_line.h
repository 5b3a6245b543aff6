// SPDX-License-Identifier: Apache-2.0
// CommandLine: the words behind a program's name, read into variables and explained by --help. CLI11
// reads them; its templates are compiled in command_line.cpp alone, since each file that includes them
// costs ten seconds.
//
//     CommandLine line("seaway-inspect", "What a scene amounts to.");
//     line.option("scene", scene, "Scene file").required().takes("SCENE.toml");
//     line.option("--time", time_s, "Sea time").between(-1e9, 1e9).takes("SECONDS");
//     const Result<CommandLine::Next> next = line.read(argc, argv);
//     if (!next) ...                               // one line that says what is wrong
//     if (*next == CommandLine::Next::leave) ...   // help or version was asked for and printed
#pragma once

#include <initializer_list>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "base/result.h"

namespace CLI {
class App;
class Option;
} // namespace CLI

namespace seaway {

/// One option, described further. Valid while its CommandLine is.
class CommandOption {
  public:
    explicit CommandOption(CLI::Option* option) : option_(option) {}

    CommandOption& takes(const std::string& what); ///< the word that --help has for its value
    CommandOption& shows_default();
    CommandOption& required();
    CommandOption& needs(const CommandOption& other);
    CommandOption& excludes(const CommandOption& other);
    CommandOption& separated_by(char delimiter);
    CommandOption& one_at_a_time(); ///< of a list: one value each time the option is given
    CommandOption& one_of(const std::vector<std::string>& words);
    CommandOption& one_of(std::initializer_list<const char*> words);
    CommandOption& one_of(std::initializer_list<int> numbers);
    CommandOption& between(int least, int most);
    CommandOption& between(double least, double most);

  private:
    CLI::Option* option_;
};

class CommandLine {
  public:
    enum class Next { go_on, leave };

    /// Has --help and --version, which also names the versions of the protocol and of the C interface; and, for who
    /// packages it, --manual and --completion (base/manual.h), not listed by --help.
    CommandLine(const std::string& program, const std::string& about);
    ~CommandLine();
    CommandLine(const CommandLine&) = delete;
    CommandLine& operator=(const CommandLine&) = delete;

    void footer(const std::string& text);

    /// T: std::string, int, double, std::uint64_t, bool (a flag) or a vector of strings or of ints.
    /// What `value` holds stays where the option is not given. An empty string is refused. Names without "-" stand by place.
    template <class T>
    CommandOption option(const std::string& names, T& value, const std::string& help = "");

    /// `name` FILE: options from a file (base/options_file.h), where the line does not say otherwise. What no
    /// option has the name of, a value of another kind or that the option refuses and a file that is none are errors that
    /// name file and line.
    void file_of_options(const std::string& name, const std::string& help);
    /// Two options say one thing: a file's value of either gives way to what the line says of the other, too.
    void say_the_same(const std::string& name, const std::string& other) {
        same_.emplace_back(name, other);
    }
    /// Which one was given; empty: none.
    const std::string& given_file_of_options() const { return file_; }
    /// "FILE:LINE: " of an option ("--drain") that the file gives and the line does not; else empty.
    std::string place_in_file(const std::string& name) const;

    /// A word such as "effects" with options of its own, of which one must then be given.
    CommandLine& command(const std::string& name, const std::string& about);
    /// Of a command: it was given.
    bool given() const;

    Result<Next> read(int argc, const char* const* argv);
    /// The same of words without the program's name.
    Result<Next> read(std::vector<std::string> words);

  private:
    explicit CommandLine(CLI::App* command);

    Result<void> add_words_of_file(std::vector<std::string>& words);
    /// What the parser says, with file and line where it is of an option that the file gives.
    std::string with_place(const std::string& why) const;

    /// What is wrong with a line that has none of its commands; or `why`.
    std::string without_command(const std::string& why) const;

    std::string version() const;

    std::unique_ptr<CLI::App> own_;
    CLI::App* app_;
    std::vector<std::unique_ptr<CommandLine>> commands_;
    std::string file_of_options_; ///< the option that names it; empty: there is none
    std::vector<std::pair<std::string, std::string>> same_;
    std::string file_;
    std::map<std::string, std::string> places_; ///< of place_in_file(), by name
};

} // namespace seaway
