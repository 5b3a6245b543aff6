// SPDX-License-Identifier: Apache-2.0
#include "client/view/sky/almanac.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>
#include <string>

#include <fmt/format.h>

namespace seaway::client {

namespace {

using std::numbers::pi;
constexpr double degree = pi / 180;

double sine(double angle_deg) {
    return std::sin(angle_deg * degree);
}
double cosine(double angle_deg) {
    return std::cos(angle_deg * degree);
}

/// Of the ecliptic of the date.
Equatorial from_ecliptic(double longitude_deg, double latitude_deg, double distance, double days) {
    const double tilt = 23.439 - 4e-7 * days;
    const glm::dvec3 ecliptic(cosine(latitude_deg) * cosine(longitude_deg),
                              cosine(latitude_deg) * sine(longitude_deg), sine(latitude_deg));
    const double y = ecliptic.y * cosine(tilt) - ecliptic.z * sine(tilt);
    const double z = ecliptic.y * sine(tilt) + ecliptic.z * cosine(tilt);
    return {std::atan2(y, ecliptic.x), std::asin(std::clamp(z, -1.0, 1.0)), distance};
}

glm::dvec3 unit(const Equatorial& body) {
    const double level = std::cos(body.declination_rad);
    return {level * std::cos(body.right_ascension_rad), level * std::sin(body.right_ascension_rad),
            std::sin(body.declination_rad)};
}

/// Columns: east, north, up at a place, as seen from among the stars.
glm::dmat3 equatorial_from_local(double sidereal_rad, double latitude_rad) {
    const double c = std::cos(sidereal_rad), s = std::sin(sidereal_rad);
    const double cl = std::cos(latitude_rad), sl = std::sin(latitude_rad);
    return {glm::dvec3(-s, c, 0), glm::dvec3(-sl * c, -sl * s, cl), glm::dvec3(cl * c, cl * s, sl)};
}

/// Day 0 of days_j2000, which begins half a day before it.
constexpr std::chrono::sys_days first_day(std::chrono::year(2000) / std::chrono::January / 1);

constexpr std::chrono::year_month_day date_of(int year, int month, int day) {
    return std::chrono::year(year) / month / day;
}

/// So many digits and nothing else: a sign is none.
bool whole(std::string_view text, std::size_t at, std::size_t digits, int lo, int hi, int& out) {
    if (text.size() < at + digits)
        return false;
    out = 0;
    for (const char c : text.substr(at, digits)) {
        if (c < '0' || c > '9')
            return false;
        out = 10 * out + (c - '0');
    }
    return out >= lo && out <= hi;
}

bool two_digits(std::string_view text, std::size_t at, char before, int lo, int hi, int& out) {
    return text.size() > at && text[at - 1] == before && whole(text, at, 2, lo, hi, out);
}

} // namespace

Result<Instant> parse_instant(std::string_view text) {
    int year = 0, month = 0, day = 0, hour = 0, minute = 0, second = 0;
    const bool seconds = text.size() == 20;
    if (!whole(text, 0, 4, year_min, year_max, year) || !(seconds || text.size() == 17) ||
        text.back() != 'Z' || !two_digits(text, 5, '-', 1, 12, month) ||
        !two_digits(text, 8, '-', 1, 31, day) || !two_digits(text, 11, 'T', 0, 23, hour) ||
        !two_digits(text, 14, ':', 0, 59, minute) ||
        (seconds && !two_digits(text, 17, ':', 0, 59, second)) || !date_of(year, month, day).ok())
        return Error{"'" + std::string(text) + "' is not an instant as 2026-06-21T04:30Z, " +
                     std::to_string(year_min) + " .. " + std::to_string(year_max)};
    const double hours = hour + minute / 60.0 + second / 3600.0;
    const auto days = std::chrono::sys_days(date_of(year, month, day)) - first_day;
    return Instant{static_cast<double>(days.count()) + (hours - 12) / 24};
}

std::string to_text(Instant when) {
    using namespace std::chrono;
    const auto since = seconds(std::llround((when.days_j2000 + 0.5) * 86400));
    const sys_seconds at = first_day + since;
    const sys_days midnight = floor<days>(at);
    const year_month_day date(midnight);
    const hh_mm_ss time(at - midnight);
    return fmt::format("{:04}-{:02}-{:02}T{:02}:{:02}:{:02}Z", static_cast<int>(date.year()),
                       static_cast<unsigned>(date.month()), static_cast<unsigned>(date.day()),
                       time.hours().count(), time.minutes().count(), time.seconds().count());
}

Equatorial sun_at(Instant when) {
    const double n = when.days_j2000;
    const double anomaly = 357.528 + 0.9856003 * n;
    const double longitude =
        280.460 + 0.9856474 * n + 1.915 * sine(anomaly) + 0.020 * sine(2 * anomaly);
    const double distance = 1.00014 - 0.01671 * cosine(anomaly) - 0.00014 * cosine(2 * anomaly);
    return from_ecliptic(longitude, 0, distance, n);
}

Equatorial moon_at(Instant when) {
    const double t = when.days_j2000 / 36525;
    const double centre = 134.9 + 477198.85 * t, evection = 259.2 - 413335.38 * t;
    const double variation = 235.7 + 890534.23 * t, twice = 269.9 + 954397.70 * t;
    const double longitude = 218.32 + 481267.8813 * t + 6.29 * sine(centre) -
                             1.27 * sine(evection) + 0.66 * sine(variation) + 0.21 * sine(twice) -
                             0.19 * sine(357.5 + 35999.05 * t) - 0.11 * sine(186.6 + 966404.05 * t);
    const double latitude = 5.13 * sine(93.3 + 483202.03 * t) + 0.28 * sine(228.2 + 960400.87 * t) -
                            0.28 * sine(318.3 + 6003.18 * t) - 0.17 * sine(217.6 - 407332.20 * t);
    const double parallax = 0.9508 + 0.0518 * cosine(centre) + 0.0095 * cosine(evection) +
                            0.0078 * cosine(variation) + 0.0028 * cosine(twice);
    return from_ecliptic(longitude, latitude, 1 / sine(parallax), when.days_j2000);
}

Heavens heavens_at(Instant when, double latitude_deg, double longitude_deg) {
    const double sidereal =
        (280.46061837 + 360.98564736629 * when.days_j2000 + longitude_deg) * degree;
    const Equatorial sun = sun_at(when), moon = moon_at(when);
    Heavens out;
    out.equatorial_from_local = equatorial_from_local(sidereal, latitude_deg * degree);
    const glm::dmat3 local = glm::transpose(out.equatorial_from_local);
    out.to_sun = glm::normalize(local * unit(sun));
    // The place is one earth's radius from the centre that the moon's distance is counted from.
    out.to_moon = glm::normalize(local * (moon.distance * unit(moon)) - glm::dvec3(0, 0, 1));
    out.sun_distance_au = sun.distance;
    // The sun is 389 times as far as the moon: seen from there it stands as it does from here.
    out.moon_phase_rad = pi - std::acos(std::clamp(glm::dot(unit(sun), unit(moon)), -1.0, 1.0));
    return out;
}

Heavens heavens_at_hour(double time_of_day_h) {
    // The sun stands where the equator rises from the ecliptic, so the sidereal time is its hour angle.
    const double hour_angle = (time_of_day_h - 12) * pi / 12;
    Heavens out;
    out.equatorial_from_local = equatorial_from_local(hour_angle, pi / 4);
    out.to_sun = glm::transpose(out.equatorial_from_local) * glm::dvec3(1, 0, 0);
    out.to_moon = -out.to_sun;
    return out;
}

double moon_brightness(double phase_rad) {
    const double angle_deg = std::abs(phase_rad) / degree;
    return std::pow(10.0, -0.4 * (0.026 * angle_deg + 4e-9 * std::pow(angle_deg, 4)));
}

} // namespace seaway::client
