// SPDX-License-Identifier: Apache-2.0
#include "client/view/look_options.h"

#include <charconv>
#include <cmath>

#include <fmt/format.h>

#include "client/view/look_file.h"
#include "client/view/look_keys.h"
#include "client/view/option_words.h"

namespace seaway::client {

namespace {

/// Of a cell of the mesh: what a device can hold, to coarser than any picture wants.
constexpr Range cells_pixels{1, 64};

Result<void> take_number(const char* option, double given, Range range, double unit, double& out) {
    if (std::isnan(given))
        return {};
    SEAWAY_TRY(require(range.contains(given),
                       fmt::format("{} {}: {} .. {}", option, given, range.lo, range.hi)));
    out = given * unit;
    return {};
}

/// A picture of the sky, or what is of a computed one: each takes the other kind of the file away.
Result<void> take_kind_of_sky(const LookWords& words, Look& look) {
    const std::pair<bool, const char*> of_computed_sky[] = {
        {!std::isnan(words.clouds), "--clouds"},
        {!std::isnan(words.hour), "--time-of-day"},
        {!words.place.empty(), "--place"},
        {!words.date.empty(), "--date"}};
    for (const auto& [given, name] : of_computed_sky) {
        SEAWAY_TRY(require(!given || words.environment.empty(),
                           fmt::format("--sky and {}: one or the other, a picture has its own sun "
                                       "and clouds",
                                       name)));
        if (given)
            look.environment.clear();
    }
    if (words.environment.empty())
        return {};
    look.environment = words.environment;
    look.environment_turn_deg = 0;
    return {};
}

/// LAT,LON and an instant, each in place of what the look says.
Result<void> take_place(const LookWords& words, Look& look) {
    if (words.place.empty() && words.date.empty())
        return {};
    PlaceAndTime place = look.place.value_or(PlaceAndTime{});
    SEAWAY_TRY(require(look.place || (!words.place.empty() && !words.date.empty()),
                       "--place and --date: both, or one of them over a look that has a place"));
    if (!words.place.empty()) {
        const std::size_t comma = words.place.find(',');
        const std::string_view text = words.place;
        SEAWAY_TRY(require(comma != std::string::npos &&
                               parse_number(text.substr(0, comma), place.latitude_deg) &&
                               parse_number(text.substr(comma + 1), place.longitude_deg) &&
                               latitudes_deg.contains(place.latitude_deg) &&
                               longitudes_deg.contains(place.longitude_deg),
                           fmt::format("--place {}: LAT,LON: {} .. {} and {} .. {} degrees, north "
                                       "and east are positive",
                                       words.place, latitudes_deg.lo, latitudes_deg.hi,
                                       longitudes_deg.lo, longitudes_deg.hi)));
    }
    if (!words.date.empty()) {
        const Result<Instant> when = parse_instant(words.date);
        SEAWAY_TRY(require(when.has_value(), "--date: " + (when ? "" : when.error().message)));
        place.when = *when;
    }
    look.place = place;
    return {};
}

/// The look's file, then what wins over it.
Result<void> take_look(const LookWords& words, Look& look) {
    if (!words.path.empty()) {
        SEAWAY_TRY_LET(look, read_look(words.path));
    }
    SEAWAY_TRY(take_kind_of_sky(words, look));
    SEAWAY_TRY(take_number("--visibility", words.visibility_km, visibilities_km, 1000,
                           look.air.visibility_m));
    SEAWAY_TRY(take_number("--clouds", words.clouds, cloud_shares, 1, look.clouds.coverage));
    SEAWAY_TRY(require(std::isnan(words.hour) || (words.place.empty() && words.date.empty()),
                       "--time-of-day and --place, --date: one or the other"));
    SEAWAY_TRY(take_number("--time-of-day", words.hour, hours, 1, look.hour));
    if (!std::isnan(words.hour))
        look.place.reset();
    SEAWAY_TRY(take_place(words, look));
    if (!words.exposure.empty()) {
        const Result<Exposure> exposure = parse_exposure(words.exposure);
        SEAWAY_TRY(require(exposure.has_value(),
                           "--exposure: " + (exposure ? "" : exposure.error().message)));
        look.exposure = *exposure;
        look.exposure_stops = 0;
    }
    look = in_force(look);
    if (words.water.empty())
        return {};
    std::string names;
    for (const auto& [name, type] : sea::water_types) {
        if (name == words.water)
            look.water = type;
        names += fmt::format("{}{}", names.empty() ? "" : ", ", name);
    }
    return require(look.water && sea::name_of(*look.water) == words.water,
                   fmt::format("--water {}: no such type; there are {}", words.water, names));
}

} // namespace

void LookWords::describe(CommandLine& line) {
    line.option("--look", path, "file of light, air, clouds and water (--list-look)");
    line.option("--list-look", list, "print the keys of looks and exit");
    line.option("--time-of-day", hour, "height of the sun: hour, 0 .. 24");
    line.option("--place", place, "LAT,LON: sun, moon and stars by almanac, with --date");
    line.option("--date", date, "UTC at sea time 0, as 2026-06-21T18:30Z");
    line.option("--visibility", visibility_km, "where 2 % of contrast is left, km");
    line.option("--sky", environment,
                "a picture of the sky: OpenEXR, latitude-longitude, kcd/m2, north in the middle");
    line.option("--clouds", clouds, "share of the sky, 0 .. 1");
    line.option("--water", water,
                "Jerlov's optical type, I, IA .. 9C, or north_sea: in place of the sea's");
    line.option("--exposure", exposure,
                "auto: metered; 14.5ev: as a camera is set, ISO 100; or a factor to kcd/m2");
    line.option("--density", density,
                "side of the mesh's far cells, pixels: finer or coarser than the quality's");
}

Result<void> LookWords::take(Look& look, std::optional<double>& cell_pixels) const {
    if (!std::isnan(density))
        SEAWAY_TRY(take_number("--density", density, cells_pixels, 1, cell_pixels.emplace()));
    return take_look(*this, look);
}

void list_look_keys() {
    for (const LookKey& row : look_keys())
        fmt::print("{:<24} {}: {}\n", fmt::format("{}.{}", row.table, row.key), allowed(row),
                   row.meaning);
}

} // namespace seaway::client
