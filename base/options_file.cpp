// SPDX-License-Identifier: Apache-2.0
#include "base/options_file.h"

#include <optional>

#include <fmt/format.h>

#include "base/messages.h"
#include "base/text_file.h"
#include "base/toml_document.h"
#include "base/toml_header.h"

namespace seaway {
namespace {

constexpr std::size_t file_bytes_max = 64 * 1024;

std::optional<std::string> word_of(const toml::node& node) {
    if (const auto* text = node.as_string())
        return text->get();
    if (const auto* whole = node.as_integer())
        return fmt::format("{}", whole->get());
    if (const auto* number = node.as_floating_point())
        return fmt::format("{}", number->get());
    return std::nullopt;
}

Result<FileOption> option_of(const std::string& path, const std::string& name,
                             const toml::node& node) {
    FileOption option{.name = name, .line = node.source().begin.line};
    const auto wrong = [&](const char* what) {
        return Error{fmt::format("{}:{}: {}: {}", path, option.line, printable(name), what)};
    };
    if (const auto* flag = node.as_boolean()) {
        option.is_bool = true;
        option.value = flag->get();
        return option;
    }
    if (const auto* list = node.as_array()) {
        for (const toml::node& one : *list) {
            const std::optional<std::string> word = word_of(one);
            if (!word)
                return wrong("a list of words or numbers is expected");
            option.words.push_back(*word);
        }
        return option;
    }
    const std::optional<std::string> word = word_of(node);
    if (!word)
        return wrong("a word, a number, true, false or a list is expected; options have no parts");
    option.words.push_back(*word);
    return option;
}

} // namespace

Result<std::vector<FileOption>> read_options_file(const std::string& path) {
    const Result<std::string> text = read_text_file(path, file_bytes_max);
    if (!text)
        return Error{fmt::format("{}: {}", path, text.error().message)};
    SEAWAY_TRY_LET(const TomlDocument document, TomlDocument::parse(*text, path));
    std::vector<FileOption> options;
    for (const auto& [key, node] : document.table()) {
        if (key.str().empty())
            return Error{
                fmt::format("{}:{}: an option without a name", path, key.source().begin.line)};
        SEAWAY_TRY_LET(FileOption option, option_of(path, std::string(key.str()), node));
        options.push_back(std::move(option));
    }
    return options;
}

} // namespace seaway
