// SPDX-License-Identifier: Apache-2.0
#include "base/command_line.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "base/manual.h"
#include "base/messages.h"
#include "base/nearest.h"
#include "base/options_file.h"

namespace seaway {

CommandOption& CommandOption::takes(const std::string& what) {
    option_->type_name(what);
    return *this;
}
CommandOption& CommandOption::shows_default() {
    option_->capture_default_str();
    return *this;
}
CommandOption& CommandOption::required() {
    option_->required();
    return *this;
}
CommandOption& CommandOption::needs(const CommandOption& other) {
    option_->needs(other.option_);
    return *this;
}
CommandOption& CommandOption::excludes(const CommandOption& other) {
    option_->excludes(other.option_);
    return *this;
}
CommandOption& CommandOption::separated_by(char delimiter) {
    option_->delimiter(delimiter);
    return *this;
}
CommandOption& CommandOption::one_at_a_time() {
    option_->allow_extra_args(false);
    return *this;
}
CommandOption& CommandOption::one_of(const std::vector<std::string>& words) {
    option_->check(CLI::IsMember(words));
    return *this;
}
CommandOption& CommandOption::one_of(std::initializer_list<const char*> words) {
    return one_of(std::vector<std::string>(words.begin(), words.end()));
}
CommandOption& CommandOption::one_of(std::initializer_list<int> numbers) {
    option_->check(CLI::IsMember(std::vector<int>(numbers)));
    return *this;
}
CommandOption& CommandOption::between(int least, int most) {
    option_->check(CLI::Range(least, most));
    return *this;
}
CommandOption& CommandOption::between(double least, double most) {
    const std::string range = fmt::format("{:g} .. {:g}", least, most);
    const auto within = [least, most, range](const std::string& word) { // CLI::Range takes nan
        double value = 0.0;
        return CLI::detail::lexical_cast(word, value) && value >= least && value <= most
                   ? std::string()
                   : fmt::format("'{}' is not a number {}", word, range);
    };
    option_->check(within, range);
    return *this;
}

CommandLine::CommandLine(const std::string& program, const std::string& about)
    : own_(std::make_unique<CLI::App>(about, program)), app_(own_.get()) {
    app_->set_version_flag("--version", version());
}

/// The numbers are those of protocol/messages.h and client/seaway.h, read by base/CMakeLists.txt.
std::string CommandLine::version() const {
    return fmt::format("{} {} (protocol {}, ABI {})", app_->get_name(), SEAWAY_VERSION,
                       SEAWAY_PROTOCOL, SEAWAY_ABI);
}

CommandLine::CommandLine(CLI::App* command) : app_(command) {}
CommandLine::~CommandLine() = default;

void CommandLine::footer(const std::string& text) {
    app_->footer(text);
}

template <class T>
CommandOption CommandLine::option(const std::string& names, T& value, const std::string& help) {
    return CommandOption(app_->add_option(names, value, help));
}
template <>
CommandOption CommandLine::option(const std::string& names, std::string& value,
                                  const std::string& help) {
    // An empty word is an unset variable of a script: never what was meant, and to the program as if
    // the option were not there.
    return CommandOption(app_->add_option(names, value, help)->check([](const std::string& word) {
        return word.empty() ? "the empty word '' is not allowed" : "";
    }));
}
template <>
CommandOption CommandLine::option(const std::string& names, double& value,
                                  const std::string& help) {
    CLI::Option* const option = app_->add_option(names, value, help);
    option->default_function(
        [&value] { return fmt::format("{}", value); }); // with all of its digits
    return CommandOption(option);
}
template <>
CommandOption CommandLine::option(const std::string& names, bool& value, const std::string& help) {
    return CommandOption(app_->add_flag(names, value, help));
}
template CommandOption CommandLine::option(const std::string&, int&, const std::string&);
template CommandOption CommandLine::option(const std::string&, std::uint64_t&, const std::string&);
template CommandOption CommandLine::option(const std::string&, std::vector<std::string>&,
                                           const std::string&);
template CommandOption CommandLine::option(const std::string&, std::vector<int>&,
                                           const std::string&);

void CommandLine::file_of_options(const std::string& name, const std::string& help) {
    option(name, file_, help).takes("FILE");
    file_of_options_ = name;
}

namespace {

bool gives(const std::string& word, const std::string& name) {
    return word == name || word.starts_with(name + "=");
}

/// The words that an option of a file stands for.
Result<std::vector<std::string>> words_of(const FileOption& option, const CLI::Option* known) {
    const std::string name = "--" + option.name;
    if (!known)
        return Error{"no option has this name (--help lists them)"};
    const bool is_flag = known->get_items_expected_max() == 0;
    if (is_flag != option.is_bool)
        return Error{is_flag ? "true or false is expected" : "a value is expected"};
    if (option.is_bool)
        return option.value ? std::vector<std::string>{name} : std::vector<std::string>{};
    if (option.words.size() > 1 && known->get_items_expected_max() == 1)
        return Error{"one value is expected"};
    std::vector<std::string> words;
    for (const std::string& word : option.words) {
        if (word.empty())
            return Error{"the empty word '' is not allowed"};
        words.push_back(name + "=" + word);
    }
    return words;
}

} // namespace

/// What the file says comes first, so that a "--" among the words does not end it.
Result<void> CommandLine::add_words_of_file(std::vector<std::string>& words) {
    places_.clear();
    const auto named = std::ranges::find_if(
        words, [this](const std::string& word) { return gives(word, file_of_options_); });
    if (file_of_options_.empty() || named == words.end())
        return {};
    const bool apart = *named == file_of_options_;
    if (apart && named + 1 == words.end())
        return {}; // the parser says that a value is missing
    const std::string path = apart ? *(named + 1) : named->substr(file_of_options_.size() + 1);
    SEAWAY_TRY_LET(const std::vector<FileOption> options, read_options_file(path));
    std::vector<std::string> added;
    for (const FileOption& option : options) {
        const std::string name = "--" + option.name;
        const bool own = name == file_of_options_ || name == "--help" || name == "--version";
        const Result<std::vector<std::string>> more =
            words_of(option, own ? nullptr : app_->get_option_no_throw(name));
        if (!more)
            return Error{fmt::format("{}:{}: {}: {}", path, option.line, printable(option.name),
                                     more.error().message)};
        const auto is_given = [&words](const std::string& given) {
            return std::ranges::any_of(words,
                                       [&](const std::string& word) { return gives(word, given); });
        };
        const bool gives_way = is_given(name) || std::ranges::any_of(same_, [&](const auto& two) {
                                   return (two.first == name && is_given(two.second)) ||
                                          (two.second == name && is_given(two.first));
                               });
        if (gives_way)
            continue;
        added.insert(added.end(), more->begin(), more->end());
        places_.emplace(name, fmt::format("{}:{}: ", path, option.line));
    }
    words.insert(words.begin(), added.begin(), added.end());
    return {};
}

std::string CommandLine::place_in_file(const std::string& name) const {
    const auto found = places_.find(name);
    return found == places_.end() ? std::string() : found->second;
}

/// It names the option before any value, mostly as its first word.
std::string CommandLine::with_place(const std::string& why) const {
    const std::size_t begin = std::min(why.find("--"), why.size());
    const std::string name = why.substr(begin, why.find_first_of(": ", begin) - begin);
    const std::string place = place_in_file(name);
    if (place.empty())
        return why;
    const std::size_t said = why.starts_with(name + ": ") ? name.size() + 2 : 0;
    return fmt::format("{}{}: {}", place, name.substr(2), why.substr(said));
}

CommandLine& CommandLine::command(const std::string& name, const std::string& about) {
    app_->require_subcommand(1);
    commands_.emplace_back(new CommandLine(app_->add_subcommand(name, about)));
    return *commands_.back();
}

bool CommandLine::given() const {
    return app_->parsed();
}

std::string CommandLine::without_command(const std::string& why) const {
    std::vector<std::string> names;
    for (const std::unique_ptr<CommandLine>& command : commands_)
        names.push_back(command->app_->get_name());
    // The parser says that a command is missing before it says which word was none.
    const std::vector<std::string> unknown = app_->remaining();
    const auto word =
        std::ranges::find_if(unknown, [](const std::string& one) { return !one.starts_with('-'); });
    if (word != unknown.end() && word == unknown.begin())
        return fmt::format("'{}' is none of its commands{}", printable(*word),
                           nearest_of(*word, names));
    if (unknown.empty() && why.find("subcommand") != std::string::npos)
        return fmt::format("a command is missing: {}", fmt::join(names, ", "));
    return why;
}

Result<CommandLine::Next> CommandLine::read(int argc, const char* const* argv) {
    return read(std::vector<std::string>(argv + std::min(argc, 1), argv + argc));
}

Result<CommandLine::Next> CommandLine::read(std::vector<std::string> words) {
    if (words.size() == 1 && (words[0] == "--manual" || words[0] == "--completion")) {
        fmt::print("{}",
                   words[0] == "--manual" ? manual_page(*app_, version()) : bash_completion(*app_));
        return Next::leave;
    }
    // "seaway-ctl set --help", without what would come before.
    const auto command = std::ranges::find_if(commands_, [&](const auto& one) {
        return !words.empty() && one->app_->get_name() == words[0];
    });
    if (command != commands_.end() && words.size() == 2 &&
        (words[1] == "--help" || words[1] == "-h")) {
        fmt::print("{}", (*command)->app_->help(app_->get_name()));
        return Next::leave;
    }
    SEAWAY_TRY(add_words_of_file(words));
    std::reverse(words.begin(), words.end()); // as the parser wants them
    try {
        app_->parse(std::move(words));
    } catch (const CLI::Success& asked) {
        app_->exit(asked); // prints
        return Next::leave;
    } catch (const CLI::ParseError& error) {
        std::string line = error.what();
        if (!commands_.empty() && app_->get_subcommands().empty())
            line = without_command(line);
        std::replace(line.begin(), line.end(), '\n', ' ');
        return Error{with_place(line)};
    }
    return Next::go_on;
}

} // namespace seaway
