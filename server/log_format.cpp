// SPDX-License-Identifier: Apache-2.0
#include "server/log_format.h"

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <future>
#include <memory>
#include <system_error>
#include <thread>

#include <nlohmann/json.hpp>
#include <spdlog/async.h>
#include <spdlog/pattern_formatter.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include "base/messages.h"
#include "base/quiet_thread.h"
#include "base/thread_name.h"

namespace seaway::server {
namespace {

using nlohmann::ordered_json;

constexpr const char* iso_time = "%Y-%m-%dT%H:%M:%S.%e%z";

ordered_json value_of(std::string_view text) {
    if (text == "true" || text == "false")
        return text == "true";
    const char* const end = text.data() + text.size();
    std::int64_t whole = 0;
    if (const auto [at, wrong] = std::from_chars(text.data(), end, whole);
        at == end && wrong == std::errc())
        return whole;
    double number = 0;
    if (const auto [at, wrong] = std::from_chars(text.data(), end, number);
        at == end && wrong == std::errc() && std::isfinite(number))
        return number;
    return std::string(text);
}

/// Words that are quoted may hold quotes: they end where the line does or another key follows.
std::size_t end_of_quote(std::string_view text) {
    for (std::size_t at = text.find('"'); at != std::string_view::npos;
         at = text.find('"', at + 1)) {
        const std::string_view rest = text.substr(at + 1);
        const std::size_t key_end = rest.find_first_not_of("abcdefghijklmnopqrstuvwxyz_", 1);
        if (rest.empty() ||
            (rest.front() == ' ' && key_end > 1 && key_end < rest.size() && rest[key_end] == '='))
            return at;
    }
    return text.size();
}

/// Of `key=value key="many words"`; ends at what is neither.
ordered_json fields_of(std::string_view message) {
    ordered_json fields = ordered_json::object();
    while (!message.empty()) {
        const std::size_t equals = message.find('=');
        if (equals == std::string_view::npos ||
            message.substr(0, equals).find(' ') != std::string_view::npos)
            break;
        const std::string key(message.substr(0, equals));
        message.remove_prefix(equals + 1);
        const bool quoted = message.starts_with('"');
        message.remove_prefix(quoted ? 1 : 0);
        const std::size_t end =
            quoted ? end_of_quote(message) : std::min(message.find(' '), message.size());
        const std::string_view text = message.substr(0, end);
        fields[key] = quoted ? ordered_json(std::string(text)) : value_of(text);
        message.remove_prefix(std::min(end + (quoted ? 2 : 1), message.size()));
    }
    return fields;
}

/// Writes a whole line as JSON; its pattern is the time alone.
class JsonFormatter final : public spdlog::formatter {
  public:
    void format(const spdlog::details::log_msg& message, spdlog::memory_buf_t& out) override {
        spdlog::memory_buf_t time;
        time_.format(message, time);
        const spdlog::string_view_t level = spdlog::level::to_string_view(message.level);
        const std::string line = json_line({time.data(), time.size()}, {level.data(), level.size()},
                                           {message.payload.data(), message.payload.size()}) +
                                 "\n";
        out.append(line.data(), line.data() + line.size());
    }
    std::unique_ptr<spdlog::formatter> clone() const override {
        return std::make_unique<JsonFormatter>();
    }

  private:
    spdlog::pattern_formatter time_{iso_time, spdlog::pattern_time_type::local, ""};
};

constexpr const char* log_name = "seaway-server";
constexpr std::size_t lines_waiting_max = 8192;
using Sink = spdlog::sinks::stderr_color_sink_mt;
bool is_json = false;

void apply_format() {
    if (is_json)
        spdlog::set_formatter(std::make_unique<JsonFormatter>());
    else
        spdlog::set_pattern(std::string(iso_time) + " %l %v");
}

void log_on_its_own_thread() {
    {
        const QuietThreads quiet; // signals are main's
        spdlog::init_thread_pool(lines_waiting_max, 1, [] { name_thread("sea-log"); });
    }
    spdlog::set_default_logger(std::make_shared<spdlog::async_logger>(
        log_name, std::make_shared<Sink>(), spdlog::thread_pool(),
        spdlog::async_overflow_policy::overrun_oldest));
}

bool is_unread = false; ///< at the end

/// With who reads the log, at its end.
constexpr std::chrono::seconds patience_with_readers{1};

} // namespace

std::string json_line(std::string_view time, std::string_view level, std::string_view message) {
    ordered_json line{{"time", time}, {"level", level}, {"message", message}};
    if (message.starts_with("event="))
        line["fields"] = fields_of(message);
    return line.dump(-1, ' ', false, ordered_json::error_handler_t::replace);
}

void set_log_format(const std::string& format) {
    if (spdlog::thread_pool() == nullptr)
        log_on_its_own_thread();
    is_json = format == "json";
    apply_format();
}

LogEnd::~LogEnd() {
    // By another thread: a line that nobody reads is waited for by nobody who has something to say of how it ended.
    const auto written = std::make_shared<std::promise<void>>();
    try {
        std::thread([written] {
            spdlog::shutdown();
            written->set_value();
        }).detach();
    } catch (const std::system_error&) { // no further thread
        spdlog::shutdown();
        written->set_value();
    }
    is_unread = written->get_future().wait_for(patience_with_readers) != std::future_status::ready;
    if (is_unread)
        return;
    spdlog::set_default_logger(
        std::make_shared<spdlog::logger>(log_name, std::make_shared<Sink>()));
    apply_format();
}

int end_with(int status) {
    if (is_unread)
        std::_Exit(status);
    return status;
}

int give_up(int status, const std::string& why) {
    end_with(status); // nobody would read why
    if (!is_json)
        return complain(log_name, status, why);
    spdlog::critical("{}", why);
    return status;
}

} // namespace seaway::server
