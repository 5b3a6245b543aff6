// SPDX-License-Identifier: Apache-2.0
#include "server/device/kernel_choices.h"

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <random>
#include <string_view>
#include <system_error>

#include <fmt/format.h>

#include "base/text_file.h"

namespace seaway::server {

namespace {

constexpr std::string_view head = "seaway kernels 1";
constexpr std::size_t bytes_max = std::size_t{1} << 20;
constexpr std::size_t choices_max = 1000; ///< the oldest go
constexpr std::size_t columns = 7;

std::vector<std::string> cells_of(std::string_view line) {
    std::vector<std::string> cells;
    for (std::size_t from = 0; from <= line.size();) {
        const std::size_t tab = std::min(line.find('\t', from), line.size());
        cells.emplace_back(line.substr(from, tab - from));
        from = tab + 1;
    }
    return cells;
}

template <class T>
bool parse(const std::string& text, T& value, int base = 10) {
    const auto [end, failed] = std::from_chars(text.data(), text.data() + text.size(), value, base);
    return failed == std::errc() && end == text.data() + text.size();
}

std::optional<KernelChoice> choice_of(std::string_view line) {
    const std::vector<std::string> cells = cells_of(line);
    std::uint64_t microseconds = 0;
    KernelChoice choice;
    if (cells.size() != columns || (cells[3] != "band" && cells[3] != "all") ||
        !parse(cells[2], choice.size) || !parse(cells[4], choice.fingerprint, 16) ||
        cells[5].empty() || !parse(cells[6], microseconds))
        return std::nullopt;
    choice.device = cells[0];
    choice.driver = cells[1];
    choice.band_limited = cells[3] == "band";
    choice.design = cells[5];
    choice.seconds = 1e-6 * static_cast<double>(microseconds);
    return choice;
}

std::string line_of(const KernelChoice& choice) {
    return fmt::format("{}\t{}\t{}\t{}\t{:08x}\t{}\t{:.0f}\n", choice.device, choice.driver,
                       choice.size, choice.band_limited ? "band" : "all", choice.fingerprint,
                       choice.design, 1e6 * choice.seconds);
}

/// Beside the file that it will be, under a name of this attempt alone.
Result<void> write_in_place_of(const std::string& path, const std::string& text) {
    const std::string fresh = fmt::format("{}.{:08x}", path, std::random_device()());
    std::ofstream file(fresh, std::ios::binary);
    file << text;
    file.close();
    std::error_code failed;
    if (file)
        std::filesystem::rename(fresh, path, failed);
    if (file && !failed)
        return {};
    std::error_code ignored;
    std::filesystem::remove(fresh, ignored);
    return Error{path + ": cannot be written" + (failed ? ": " + failed.message() : "")};
}

} // namespace

std::string kernel_choice_name(std::string name) {
    std::ranges::replace_if(
        name, [](unsigned char c) { return c < ' '; }, '?');
    return name;
}

std::string kernel_choices_path() {
    const auto folder = [](const char* name) {
        const char* value = std::getenv(name);
        return std::filesystem::path(value == nullptr ? "" : value);
    };
    const std::filesystem::path cache = folder("XDG_CACHE_HOME"), home = folder("HOME");
    if (cache
            .is_absolute()) // what is not is to be passed over (XDG Base Directory Specification 0.8)
        return (cache / "seaway" / "kernels.tsv").string();
    return home.is_absolute() ? (home / ".cache" / "seaway" / "kernels.tsv").string()
                              : std::string();
}

std::size_t fastest_of(std::span<const double> seconds) {
    return static_cast<std::size_t>(std::ranges::min_element(seconds) - seconds.begin());
}

Result<std::vector<KernelChoice>> read_kernel_choices(const std::string& path) {
    std::error_code failed;
    if (!std::filesystem::exists(path, failed) && !failed)
        return std::vector<KernelChoice>();
    Result<std::string> text = read_text_file(path, bytes_max);
    if (!text)
        return Error{path + ": " + text.error().message};
    std::vector<KernelChoice> choices;
    std::size_t number = 0;
    for (std::size_t from = 0; from < text->size(); ++number) {
        const std::size_t end = std::min(text->find('\n', from), text->size());
        const std::string_view line = std::string_view(*text).substr(from, end - from);
        from = end + 1;
        if (number == 0 && line != head)
            return Error{path + ": is not what this version remembers kernels in"};
        if (number == 0)
            continue;
        std::optional<KernelChoice> choice = choice_of(line);
        if (!choice)
            return Error{fmt::format("{}:{}: is damaged", path, number + 1)};
        choices.push_back(std::move(*choice));
    }
    return choices;
}

Result<void> remember_kernel_choice(const std::string& path, const KernelChoice& choice) {
    SEAWAY_TRY(check_replaceable(path));
    Result<std::vector<KernelChoice>> held = read_kernel_choices(path);
    std::vector<KernelChoice> choices = held ? std::move(*held) : std::vector<KernelChoice>();
    std::erase_if(choices, [&](const KernelChoice& old) { return old.is_of_the_same(choice); });
    if (choices.size() >= choices_max)
        choices.erase(choices.begin());
    choices.push_back(choice);
    std::string text = std::string(head) + "\n";
    for (const KernelChoice& each : choices)
        text += line_of(each);
    std::error_code failed;
    std::filesystem::create_directories(std::filesystem::path(path).parent_path(), failed);
    if (failed)
        return Error{path + ": its folder cannot be made: " + failed.message()};
    return write_in_place_of(path, text);
}

} // namespace seaway::server
