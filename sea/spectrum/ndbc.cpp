// SPDX-License-Identifier: Apache-2.0
#include "sea/spectrum/ndbc.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <tuple>
#include <vector>

#include <fmt/format.h>

namespace seaway::sea {

namespace {

/// What files say in the place of a number, besides MM. Densities of the real-time form have MM alone: such seas exist.
bool is_fill(double value) {
    return value == 999.0 || value == 9999.0;
}

enum class Quantity : std::uint8_t { density, direction };
constexpr double hundredths = 0.01;

std::vector<std::string_view> words_of(std::string_view line) {
    constexpr std::string_view blank = " \t\r";
    std::vector<std::string_view> words;
    for (;;) {
        const std::size_t first = line.find_first_not_of(blank);
        if (first == std::string_view::npos)
            return words;
        line.remove_prefix(first);
        const std::size_t end = std::min(line.find_first_of(blank), line.size());
        words.push_back(line.substr(0, end));
        line.remove_prefix(end);
    }
}

std::string_view next_line(std::string_view& text) {
    const std::size_t end = text.find('\n');
    const std::string_view line = text.substr(0, end);
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    return line;
}

/// The words of the first line that has any; `text` goes on behind it.
std::vector<std::string_view> first_words(std::string_view& text) {
    while (!text.empty())
        if (std::vector<std::string_view> words = words_of(next_line(text)); !words.empty())
            return words;
    return {};
}

std::optional<double> number_of(std::string_view word) {
    double value = 0.0;
    const auto [end, problem] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (problem != std::errc() || end != word.data() + word.size() || !std::isfinite(value))
        return std::nullopt;
    return value;
}

std::optional<double> frequency_in_brackets(std::string_view word) {
    if (word.size() < 3 || word.front() != '(' || word.back() != ')')
        return std::nullopt;
    return number_of(word.substr(1, word.size() - 2));
}

bool begins_as_header(const std::vector<std::string_view>& words) {
    return words.size() > 4 && (words[0] == "#YY" || words[0] == "YY" || words[0] == "YYYY") &&
           words[1] == "MM" && words[2] == "DD";
}

struct Value {
    double f_hz;
    std::optional<double> value; ///< absent: missing
};

struct Record {
    std::int64_t time = -1; ///< YYYYMMDDhhmm
    std::vector<Value> values;
};

std::string written(std::int64_t time) {
    return fmt::format("{:04}-{:02}-{:02}T{:02}:{:02}", time / 100000000, time / 1000000 % 100,
                       time / 10000 % 100, time / 100 % 100, time % 100);
}

/// One file, line by line.
class RecordReader {
  public:
    RecordReader(const NdbcText& file, Quantity quantity)
        : file_(file), quantity_(quantity), rest_(file.text) {}

    /// The record of this time, or the newest for -1.
    Result<Record> find(std::int64_t wanted) {
        header_ = first_words(rest_);
        if (!begins_as_header(header_))
            return Error{
                fmt::format("{}: no header of an NDBC file, #YY MM DD hh mm ...", file_.name)};
        minutes_ = header_[4] == "mm";
        const std::size_t date_words = minutes_ ? 5 : 4;
        bracketed_ = header_.back() == ">";
        separation_ = bracketed_ && header_.size() > 5 && header_[5] == "Sep_Freq";
        Record best;
        std::vector<std::string_view> best_words;
        while (!rest_.empty()) {
            std::vector<std::string_view> words = words_of(next_line(rest_));
            if (words.empty() || words[0].front() == '#')
                continue;
            const std::optional<std::int64_t> time = time_of(words, date_words);
            if (!time)
                return Error{
                    fmt::format("{}: '{}' does not begin with a date", file_.name, words[0])};
            if (wanted >= 0 ? *time == wanted : *time > best.time) {
                best.time = *time;
                best_words = std::move(words);
            }
        }
        if (best.time < 0)
            return Error{wanted < 0
                             ? fmt::format("{}: no record", file_.name)
                             : fmt::format("{}: no record of {}", file_.name, written(wanted))};
        return fill(best, best_words, date_words);
    }
    bool archived() const { return !bracketed_; }

  private:
    std::optional<std::int64_t> time_of(const std::vector<std::string_view>& words,
                                        std::size_t count) const {
        if (words.size() < count)
            return std::nullopt;
        constexpr std::int64_t largest[] = {9999, 12, 31, 23, 59};
        std::int64_t parts[5] = {0, 0, 0, 0, 0};
        for (std::size_t i = 0; i < count; ++i) {
            const std::optional<double> part = number_of(words[i]);
            if (!part || *part != std::floor(*part) || *part < 0.0 ||
                *part > static_cast<double>(largest[i]))
                return std::nullopt;
            parts[i] = static_cast<std::int64_t>(*part);
        }
        if (parts[0] < 100)
            parts[0] += 1900; // two digits end with 1998
        return (((parts[0] * 100 + parts[1]) * 100 + parts[2]) * 100 + parts[3]) * 100 + parts[4];
    }

    Result<Record> fill(Record record, const std::vector<std::string_view>& words,
                        std::size_t date_words) const {
        const auto bad = [&](std::string_view word) {
            return Error{fmt::format("{}: record of {}: '{}' is not what stands here", file_.name,
                                     written(record.time), word)};
        };
        const std::size_t begin = date_words + (separation_ ? 1 : 0);
        const std::size_t step = bracketed_ ? 2 : 1;
        if (words.size() < begin + step || (words.size() - begin) % step != 0 ||
            (!bracketed_ && words.size() != header_.size()))
            return Error{fmt::format("{}: record of {} has {} words", file_.name,
                                     written(record.time), words.size())};
        for (std::size_t i = begin; i < words.size(); i += step) {
            const std::optional<double> f =
                bracketed_ ? frequency_in_brackets(words[i + 1]) : number_of(header_[i]);
            if (!f)
                return bad(bracketed_ ? words[i + 1] : header_[i]);
            const std::optional<double> value = number_of(words[i]);
            if (!value && words[i] != "MM")
                return bad(words[i]);
            const bool filled = quantity_ == Quantity::direction || archived();
            record.values.push_back(
                {*f, value && !(filled && is_fill(*value)) ? value : std::nullopt});
        }
        return record;
    }

    const NdbcText& file_;
    Quantity quantity_;
    std::string_view rest_;
    std::vector<std::string_view> header_;
    bool minutes_ = true;
    bool bracketed_ = true;
    bool separation_ = false;
};

/// YYYY-MM-DDThh:mm as YYYYMMDDhhmm.
std::optional<std::int64_t> time_from(std::string_view text) {
    constexpr std::string_view form = "0000-00-00T00:00";
    if (text.size() != form.size())
        return std::nullopt;
    std::int64_t time = 0;
    for (std::size_t i = 0; i < form.size(); ++i) {
        const bool digit = text[i] >= '0' && text[i] <= '9';
        if (form[i] == '0' ? !digit : text[i] != form[i])
            return std::nullopt;
        if (digit)
            time = time * 10 + (text[i] - '0');
    }
    return time;
}

/// One of the four directional quantities at the frequencies of the densities.
Result<std::vector<std::optional<double>>> beside(const NdbcText& file, const Record& density,
                                                  bool is_share) {
    RecordReader reader(file, Quantity::direction);
    const Result<Record> record = reader.find(density.time);
    if (!record)
        return record.error();
    const bool same = std::equal(
        record->values.begin(), record->values.end(), density.values.begin(), density.values.end(),
        [](const Value& a, const Value& b) { return std::abs(a.f_hz - b.f_hz) < 1e-6; });
    if (!same)
        return Error{fmt::format("{}: record of {}: its frequencies are not those of the densities",
                                 file.name, written(density.time))};
    std::vector<std::optional<double>> values;
    for (const Value& value : record->values)
        values.push_back(value.value && is_share && reader.archived() ? *value.value * hundredths
                                                                      : value.value);
    return values;
}

} // namespace

bool is_ndbc(std::string_view text) {
    return begins_as_header(first_words(text));
}

Result<std::string> ndbc_to_csv(const NdbcTexts& texts, const std::string& time_utc) {
    const std::optional<std::int64_t> wanted =
        time_utc.empty() ? std::optional<std::int64_t>(-1) : time_from(time_utc);
    if (!wanted)
        return Error{fmt::format("time_utc = \"{}\"; a time is YYYY-MM-DDThh:mm", time_utc)};
    const Result<Record> density = RecordReader(texts.density, Quantity::density).find(*wanted);
    if (!density)
        return density.error();
    std::string csv = "f_hz,f_lo_hz,f_hi_hz,s_m2_hz";
    std::vector<std::vector<std::optional<double>>> directions;
    for (const auto& [file, column, is_share] : {std::tuple{&texts.r1, ",r1", true},
                                                 {&texts.alpha1, ",alpha1_deg", false},
                                                 {&texts.r2, ",r2", true},
                                                 {&texts.alpha2, ",alpha2_deg", false}}) {
        if (!*file)
            continue;
        auto values = beside(**file, *density, is_share);
        if (!values)
            return values.error();
        directions.push_back(*std::move(values));
        csv += column;
    }
    csv += '\n';
    const std::vector<Value>& bins = density->values;
    if (bins.size() < 2)
        return Error{fmt::format("{}: record of {}: fewer than two frequencies", texts.density.name,
                                 written(density->time))};
    for (std::size_t i = 0; i < bins.size(); ++i) {
        const double f = bins[i].f_hz;
        if (!bins[i].value)
            return Error{fmt::format("{}: record of {}: no density at {} Hz; another record is "
                                     "chosen with time_utc",
                                     texts.density.name, written(density->time), f)};
        const double below = i > 0 ? bins[i - 1].f_hz : f - (bins[i + 1].f_hz - f);
        const double above = i + 1 < bins.size() ? bins[i + 1].f_hz : f + (f - below);
        csv += fmt::format("{},{},{},{}", f, 0.5 * (below + f), 0.5 * (f + above), *bins[i].value);
        const bool directed = std::all_of(directions.begin(), directions.end(),
                                          [i](const auto& d) { return d[i].has_value(); });
        for (const auto& d : directions)
            csv += fmt::format(",{}", directed ? *d[i] : 0.0);
        csv += '\n';
    }
    return csv;
}

} // namespace seaway::sea
