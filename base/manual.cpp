// SPDX-License-Identifier: Apache-2.0
#include "base/manual.h"

#include <algorithm>
#include <cctype>
#include <string_view>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

namespace seaway {
namespace {

using Options = std::vector<const CLI::Option*>;

/// Text as roff takes it: no character of it is a request, and "-" is the one that is typed.
std::string roff(const std::string& text) {
    std::string written;
    for (const char character : text) {
        const bool line_begins = written.empty() || written.back() == '\n';
        if (line_begins && (character == '.' || character == '\''))
            written += "\\&";
        if (character == '\\')
            written += "\\e";
        else if (character == '-')
            written += "\\-";
        else
            written += character;
    }
    return written;
}

std::string upper(std::string text) {
    std::transform(text.begin(), text.end(), text.begin(),
                   [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
    return text;
}

Options shown(const CLI::App& app, bool positional) {
    return app.get_options([positional](const CLI::Option* option) {
        return !option->get_group().empty() && option->get_positional() == positional;
    });
}

std::vector<const CLI::App*> commands_of(const CLI::App& app) {
    return app.get_subcommands([](const CLI::App*) { return true; });
}

/// One sentence: what stands behind the name of a page.
std::string first_sentence(const std::string& about) {
    std::string sentence = about.substr(0, about.find(". "));
    while (!sentence.empty() && (sentence.back() == '.' || sentence.back() == '\n'))
        sentence.pop_back();
    const bool capitalised =
        sentence.size() > 1 && std::islower(static_cast<unsigned char>(sentence[1]));
    if (capitalised)
        sentence[0] = static_cast<char>(std::tolower(static_cast<unsigned char>(sentence[0])));
    return sentence;
}

std::string synopsis_of(const CLI::App& app) {
    std::string words = " [OPTIONS]";
    for (const CLI::Option* option : shown(app, true))
        words += option->get_required() ? " " + option->get_name(true)
                                        : " [" + option->get_name(true) + "]";
    return words + (commands_of(app).empty() ? "" : " COMMAND ...");
}

std::string described(const Options& options, bool positional) {
    std::string page;
    for (const CLI::Option* option : options)
        page += fmt::format(".TP\n.B {}\n{}\n",
                            roff(option->get_name(positional, !positional) +
                                 CLI::Formatter().make_option_opts(option)),
                            roff(option->get_description()));
    return page;
}

std::string described(const CLI::App& app) {
    return described(shown(app, true), true) + described(shown(app, false), false);
}

bool is_word(const std::string& text) {
    return !text.empty() && std::all_of(text.begin(), text.end(), [](unsigned char c) {
        return std::islower(c) || std::isdigit(c) || c == '-' || c == '_';
    }) && std::any_of(text.begin(), text.end(), [](unsigned char c) { return std::islower(c); });
}

/// The words among what an option takes: "table|json", "NAME:{text,json}".
std::string words_taken(const std::string& type) {
    std::vector<std::string> found;
    for (const std::string& part : CLI::detail::split(type, '|')) {
        const auto open = part.find('{');
        const auto close = part.find('}', open);
        std::vector<std::string> words{part.substr(0, part.find(':'))};
        if (open != std::string::npos && close != std::string::npos)
            for (std::string& word :
                 CLI::detail::split(part.substr(open + 1, close - open - 1), ','))
                words.push_back(std::move(word));
        for (const std::string& word : words)
            if (is_word(word) && std::find(found.begin(), found.end(), word) == found.end())
                found.push_back(word);
    }
    return CLI::detail::join(found, " ");
}

bool takes_a_path(const CLI::Option& option) {
    const std::string type = option.get_type_name();
    return type.find("FILE") != std::string::npos || type.find("DIR") != std::string::npos ||
           type.find(".toml") != std::string::npos;
}

std::string all_names(const CLI::Option& option, std::string_view between,
                      const std::string& before) {
    std::string names;
    const auto add = [&](const std::string& name) {
        names += (names.empty() ? "" : std::string(between)) + before + name;
    };
    for (const std::string& name : option.get_snames())
        add("-" + name);
    for (const std::string& name : option.get_lnames())
        add("--" + name);
    return names;
}

/// What follows an option, and what else may stand there. `command`: "" for the program itself.
std::string completed(const CLI::App& app, const std::string& command) {
    std::string cases;
    std::string words;
    for (const CLI::Option* option : shown(app, false)) {
        words += (words.empty() ? "" : " ") + all_names(*option, " ", "");
        if (option->get_items_expected_max() > 0)
            cases += fmt::format(
                "        {}) words='{}' paths={} ;;\n", all_names(*option, " | ", command + ":"),
                words_taken(option->get_type_name()), takes_a_path(*option) ? 1 : 0);
    }
    const Options places = shown(app, true);
    const bool paths = std::any_of(places.begin(), places.end(),
                                   [](const CLI::Option* place) { return takes_a_path(*place); });
    std::string commands;
    for (const CLI::App* one : commands_of(app))
        commands += (commands.empty() ? "" : " ") + one->get_name();
    return cases + fmt::format("        {}:*) words='{}' paths={}\n"
                               "            [[ $word == -* ]] && words='{}' paths=0 ;;\n",
                               command, commands, paths ? 1 : 0, words);
}

} // namespace

std::string manual_page(const CLI::App& app, const std::string& version) {
    const std::string name = app.get_name();
    std::string page = fmt::format(".TH {} 1 \"\" \"{}\" \"Seaway\"\n.SH NAME\n{} \\- {}\n"
                                   ".SH SYNOPSIS\n.B {}\n{}\n.SH DESCRIPTION\n{}\n.SH OPTIONS\n",
                                   roff(upper(name)), roff(version), roff(name),
                                   roff(first_sentence(app.get_description())), roff(name),
                                   roff(synopsis_of(app).substr(1)), roff(app.get_description()));
    page += described(app);
    const std::vector<const CLI::App*> commands = commands_of(app);
    if (!commands.empty())
        page += ".SH COMMANDS\n";
    for (const CLI::App* command : commands)
        page +=
            fmt::format(".SS {}{}\n{}\n{}", roff(command->get_name()), roff(synopsis_of(*command)),
                        roff(command->get_description()), described(*command));
    if (!app.get_footer().empty())
        page += fmt::format(".SH NOTES\n.nf\n{}\n.fi\n", roff(app.get_footer()));
    return page;
}

std::string bash_completion(const CLI::App& app) {
    const std::string name = app.get_name();
    std::string function = "_" + name;
    std::replace(function.begin(), function.end(), '-', '_');
    std::string commands;
    std::string cases;
    for (const CLI::App* command : commands_of(app)) {
        commands += (commands.empty() ? "" : " | ") + command->get_name();
        cases += completed(*command, command->get_name());
    }
    cases += completed(app, "");
    const std::string find_command =
        commands.empty()
            ? ""
            : fmt::format("    for words in \"${{COMP_WORDS[@]:1:COMP_CWORD-1}}\"; do\n"
                          "        case $words in {}) command=$words; break ;; esac\n"
                          "    done\n",
                          commands);
    return fmt::format("# Completion of {0} for bash, written by `{0} --completion`.\n{1}() {{\n"
                       "    local word=${{COMP_WORDS[COMP_CWORD]}} "
                       "before=${{COMP_WORDS[COMP_CWORD-1]}} command= words= paths=0\n"
                       "    # --name=value is three words to bash\n"
                       "    [[ $word == = ]] && word=\n"
                       "    [[ $before == = ]] && before=${{COMP_WORDS[COMP_CWORD-2]}}\n"
                       "{2}    case $command:$before in\n{3}    esac\n"
                       "    COMPREPLY=($(compgen -W \"$words\" -- \"$word\"))\n"
                       "    [[ $paths == 1 ]] && COMPREPLY+=($(compgen -f -- \"$word\"))\n"
                       "    return 0\n}}\ncomplete -o filenames -F {1} {0}\n",
                       name, function, find_command, cases);
}

} // namespace seaway
