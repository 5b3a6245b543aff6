// SPDX-License-Identifier: Apache-2.0
// Views of numbers as words: VIEW[:key=value,...].
#include <bit>
#include <charconv>
#include <cmath>

#include <fmt/format.h>

#include "client/view/debug_views.h"
#include "client/view/sea/device_sea.h"

namespace seaway::client {

namespace {

constexpr std::array<std::string_view, debug_keys> key_names{"cascade", "mip",  "channel", "gain",
                                                             "bias",    "flip", "legend"};

template <class Number>
bool parse_whole(std::string_view text, Number& value) {
    const auto [end, failure] = std::from_chars(text.data(), text.data() + text.size(), value);
    return !text.empty() && failure == std::errc{} && end == text.data() + text.size();
}

/// As it is written behind "key=".
std::string range_text(const DebugViewInfo& row, DebugKey key) {
    switch (key) {
    case DebugKey::cascade:
        return fmt::format("0..{}{}", shaders::view_cascades_max - 1,
                           row.cascades == DebugViewInfo::Cascades::all_or_one ? "|all" : "");
    case DebugKey::mip:
        return fmt::format("0..{}", row.mip_max);
    case DebugKey::channel: {
        std::string names;
        for (int i = 0; i < row.channel_count(); ++i)
            names += (names.empty() ? "" : "|") +
                     std::string(row.channels[static_cast<std::size_t>(i)].name);
        return names;
    }
    case DebugKey::gain:
        return fmt::format("{:g}..{:g}", Colouring::gain_min, Colouring::gain_max);
    case DebugKey::bias:
        return fmt::format("{:g}..{:g}", -Colouring::bias_max, Colouring::bias_max);
    case DebugKey::flip:
    case DebugKey::legend:
        break;
    }
    return "on|off";
}

bool read_switch(std::string_view text, bool& value) {
    value = text == "on";
    return value || text == "off";
}

bool read_within(std::string_view text, double least, double most, double& value) {
    return parse_whole(text, value) && value >= least && value <= most; // NaN is neither
}

/// False: the value is none that this key may have.
bool read_value(const DebugViewInfo& row, DebugKey key, std::string_view text,
                DebugChoice& choice) {
    switch (key) {
    case DebugKey::cascade:
        if (text == "all" && row.cascades == DebugViewInfo::Cascades::all_or_one) {
            choice.cascade = DebugChoice::unset;
            return true;
        }
        return parse_whole(text, choice.cascade) && choice.cascade >= 0 &&
               choice.cascade < shaders::view_cascades_max;
    case DebugKey::mip:
        return parse_whole(text, choice.mip) && choice.mip >= 0 && choice.mip <= row.mip_max;
    case DebugKey::channel:
        for (int i = 0; i < row.channel_count(); ++i)
            if (row.channels[static_cast<std::size_t>(i)].name == text) {
                choice.colouring.channel = i;
                return true;
            }
        return false;
    case DebugKey::gain:
        return read_within(text, Colouring::gain_min, Colouring::gain_max, choice.colouring.gain);
    case DebugKey::bias:
        return read_within(text, -Colouring::bias_max, Colouring::bias_max, choice.colouring.bias);
    case DebugKey::flip:
        return read_switch(text, choice.colouring.flip);
    case DebugKey::legend:
        return read_switch(text, choice.legend);
    }
    return false;
}

/// One "key=value", or a number alone.
Result<void> read_setting(const DebugViewInfo& row, std::string_view setting, DebugChoice& choice,
                          std::array<bool, debug_keys>& given) {
    const std::size_t equals = setting.find('=');
    int number = 0;
    const bool alone = equals == std::string_view::npos && parse_whole(setting, number) &&
                       row.takes(DebugKey::cascade);
    const std::string_view name = alone ? "cascade" : setting.substr(0, equals);
    const std::string_view value = alone                              ? setting
                                   : equals == std::string_view::npos ? ""
                                                                      : setting.substr(equals + 1);
    const std::string keys = keys_text(row);
    for (std::size_t i = 0; i < debug_keys; ++i) {
        const auto key = static_cast<DebugKey>(i);
        if (key_names[i] != name || !row.takes(key))
            continue;
        if (given[i])
            return Error{fmt::format("{} stands twice", name)};
        given[i] = true;
        if (!read_value(row, key, value, choice))
            return Error{fmt::format("{} '{}': it is {}; keys of {}: {}", name, value,
                                     range_text(row, key), row.name, keys)};
        return {};
    }
    return Error{fmt::format("{} has no key '{}'; {}", row.name, name,
                             keys.empty() ? "it has none" : "its keys are " + keys)};
}

} // namespace

std::string keys_text(const DebugViewInfo& row) {
    std::string text;
    for (std::size_t i = 0; i < debug_keys; ++i)
        if (row.takes(static_cast<DebugKey>(i)))
            text += fmt::format("{}{}={}", text.empty() ? "" : ", ", key_names[i],
                                range_text(row, static_cast<DebugKey>(i)));
    return text;
}

Result<DebugChoice> parse_debug_view(std::string_view text) {
    const std::size_t colon = text.find(':');
    const std::string_view name = text.substr(0, colon);
    std::string names;
    for (const DebugViewInfo& row : debug_view_table()) {
        names += (names.empty() ? "" : ", ") + std::string(row.name);
        if (row.name != name)
            continue;
        DebugChoice choice{.view = row.view};
        std::array<bool, debug_keys> given{};
        std::size_t from = colon == std::string_view::npos ? text.size() + 1 : colon + 1;
        while (from <= text.size()) {
            const std::size_t comma = std::min(text.find(',', from), text.size());
            if (const Result<void> read =
                    read_setting(row, text.substr(from, comma - from), choice, given);
                !read)
                return Error{fmt::format("--debug {}: {}", text, read.error().message)};
            from = comma + 1;
        }
        return choice;
    }
    return Error{fmt::format("--debug {}: no such view; there are {}, and all", text, names)};
}

std::string debug_text(const DebugChoice& choice) {
    const DebugViewInfo& row = info(choice.view);
    std::string text;
    const auto add = [&](DebugKey key, bool set, const std::string& value) {
        if (set && row.takes(key))
            text += fmt::format("{}{}={}", text.empty() ? ":" : ",",
                                key_names[static_cast<std::size_t>(key)], value);
    };
    const Colouring& colouring = choice.colouring;
    add(DebugKey::cascade, choice.cascade >= 0, std::to_string(choice.cascade));
    add(DebugKey::mip, choice.mip > 0, std::to_string(choice.mip));
    if (colouring.channel >= 0)
        add(DebugKey::channel, true,
            std::string(row.channels[static_cast<std::size_t>(colouring.channel)].name));
    add(DebugKey::gain, colouring.gain != 1, fmt::format("{:g}", colouring.gain));
    add(DebugKey::bias, colouring.bias != 0, fmt::format("{:g}", colouring.bias));
    add(DebugKey::flip, colouring.flip, "on");
    add(DebugKey::legend, !choice.legend, "off");
    return std::string(row.name) + text;
}

Result<void> check_debug(const DebugChoice& choice, std::span<const int> points,
                         int nodes_a_point) {
    const DebugViewInfo& row = info(choice.view);
    const int cascades = static_cast<int>(points.size());
    if (choice.cascade >= cascades)
        return Error{fmt::format("--debug {}: cascade {}: this sea has {}, 0..{}",
                                 debug_text(choice), choice.cascade, cascades, cascades - 1)};
    if (row.source != DebugSource::map)
        return {};
    const int cascade = shown_cascade(choice, cascades);
    const int side = points[static_cast<std::size_t>(cascade)];
    const int texels = choice.view == DebugView::map_displacement
                           ? side
                           : DeviceSea::nodes_of(side, {.nodes_a_point = nodes_a_point});
    const int last = static_cast<int>(std::bit_width(static_cast<unsigned>(texels))) - 1;
    if (choice.mip > last)
        return Error{fmt::format("--debug {}: mip {}: this map of cascade {} has {} x {} texels, "
                                 "levels 0..{}",
                                 debug_text(choice), choice.mip, cascade, texels, texels, last)};
    return {};
}

} // namespace seaway::client
