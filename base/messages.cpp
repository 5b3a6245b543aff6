// SPDX-License-Identifier: Apache-2.0
#include "base/messages.h"

#include <algorithm>
#include <cstdio>
#include <exception>
#include <new>
#include <system_error>

#include <fmt/format.h>
#include <unistd.h>

#include "base/standard_files.h"

namespace seaway {

namespace {

/// Bytes of the character of UTF-8 at the start of `text`; 0 where there is none. Not those that
/// encode control characters (U+0080 .. U+009F), surrogates or what is beyond U+10FFFF, and none that
/// is longer than it need be.
std::size_t character_bytes(std::string_view text) {
    const auto byte = [&](std::size_t i) {
        return i < text.size() ? static_cast<unsigned char>(text[i]) : 0u;
    };
    const auto follows = [&](std::size_t i, unsigned lo, unsigned hi) {
        return byte(i) >= lo && byte(i) <= hi;
    };
    const unsigned first = byte(0);
    if (first < 0x80)
        return first >= 0x20 && first != 0x7F ? 1 : 0;
    if (first >= 0xC2 && first <= 0xDF)
        return follows(1, first == 0xC2 ? 0xA0 : 0x80, 0xBF) ? 2 : 0;
    if (first >= 0xE0 && first <= 0xEF)
        return follows(1, first == 0xE0 ? 0xA0 : 0x80, first == 0xED ? 0x9F : 0xBF) &&
                       follows(2, 0x80, 0xBF)
                   ? 3
                   : 0;
    if (first >= 0xF0 && first <= 0xF4)
        return follows(1, first == 0xF0 ? 0x90 : 0x80, first == 0xF4 ? 0x8F : 0xBF) &&
                       follows(2, 0x80, 0xBF) && follows(3, 0x80, 0xBF)
                   ? 4
                   : 0;
    return 0;
}

std::string shown_of(std::string_view text, std::size_t bytes_max) {
    std::string shown;
    while (!text.empty()) {
        if (shown.size() >= bytes_max)
            return shown + " [...]";
        const std::size_t bytes = character_bytes(text);
        if (bytes > 0)
            shown += text.substr(0, bytes);
        else if (text.front() == '\n')
            shown += ' ';
        else
            shown += fmt::format("\\x{:02x}", static_cast<unsigned char>(text.front()));
        text.remove_prefix(bytes > 0 ? bytes : 1);
    }
    return shown;
}

} // namespace

bool is_printable(std::string_view text) {
    while (!text.empty()) {
        const std::size_t bytes = character_bytes(text);
        if (bytes == 0)
            return false;
        text.remove_prefix(bytes);
    }
    return true;
}

std::string printable(std::string_view text) {
    return shown_of(text, printable_bytes_max);
}

std::string in_quotes(std::string_view text) {
    std::string inside = shown_of(text, std::string::npos);
    std::replace(inside.begin(), inside.end(), '"', '\'');
    return '"' + inside + '"';
}

int complain(const char* program, int status, std::string_view message) {
    tell(fmt::format("{}: {}\n", program, printable(message)));
    return status;
}

void tell(std::string_view text) {
    std::fwrite(text.data(), 1, text.size(), stderr);
}

int run_main(const char* program, int status, const std::function<int()>& body) {
    hold_standard_files();
    try {
        return body();
    } catch (const std::bad_alloc&) { // nor is there any for a formatted line
        for (const char* part : {program, ": out of memory\n"})
            std::fputs(part, stderr);
        return status;
    } catch (const std::system_error& problem) {
        const bool threads = problem.code() == std::errc::resource_unavailable_try_again;
        return complain(program, status, threads ? no_further_thread : problem.what());
    } catch (const std::exception& problem) {
        return complain(program, status, problem.what());
    }
}

bool stderr_is_terminal() {
    return ::isatty(STDERR_FILENO) != 0;
}

} // namespace seaway
