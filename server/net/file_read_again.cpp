// SPDX-License-Identifier: Apache-2.0
#include "server/net/file_read_again.h"

#include <fmt/format.h>

#include "base/check.h"
#include "base/hash.h"
#include "base/messages.h"
#include "base/text_file.h"

namespace seaway::server {
namespace {

/// Of scenes, options, tokens and certificates.
constexpr std::size_t file_bytes_max = 16u * 1024 * 1024;

} // namespace

std::string_view name(ReadAgain outcome) {
    switch (outcome) {
    case ReadAgain::read_again:
        return "read_again";
    case ReadAgain::unchanged:
        return "unchanged";
    case ReadAgain::failed:
        return "failed";
    case ReadAgain::kept:
        return "kept";
    case ReadAgain::needs_restart:
        return "needs_restart";
    case ReadAgain::next_connection:
        return "next_connection";
    }
    SEAWAY_CHECK(false, "an outcome");
    return {};
}

std::string FileReadAgain::line() const {
    std::string text = "event=file_read_again";
    if (!option.empty())
        text += " option=" + in_quotes(option);
    text += fmt::format(" file={} outcome={}", in_quotes(path), name(outcome));
    if (!why.empty())
        text += " why=" + in_quotes(why);
    return text;
}

std::optional<std::uint64_t> fingerprint_of(const std::string& path) {
    const Result<std::string> text = read_text_file(path, file_bytes_max);
    if (!text)
        return std::nullopt;
    return text_hash(*text);
}

} // namespace seaway::server
