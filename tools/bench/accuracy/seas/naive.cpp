// SPDX-License-Identifier: Apache-2.0
#include "tools/bench/accuracy/seas/naive.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace seaway::bench {

namespace {

struct Cell {
    int index;
    int next;
    double fraction;
};

Cell cell(double x_m, double length_m, int size) {
    const double turns = x_m / length_m;
    const double u = (turns - std::floor(turns)) * size;
    const int index = std::min(static_cast<int>(u), size - 1);
    return {index, (index + 1) % size, u - index};
}

/// The wave itself and its time rates, from one spline map.
sea::LagrangianPoint spline_point(const sea::SplineMap& map, double x_m, double y_m) {
    const sea::SplineSample s = map.sample(x_m, y_m);
    sea::LagrangianPoint p;
    p.height = static_cast<double>(s.value[0]);
    p.displacement_x = static_cast<double>(s.value[1]);
    p.displacement_y = static_cast<double>(s.value[2]);
    p.height_rate = static_cast<double>(s.value[4]);
    p.displacement_x_rate = static_cast<double>(s.value[5]);
    p.displacement_y_rate = static_cast<double>(s.value[6]);
    p.slope_x = static_cast<double>(s.d_dx[0]);
    p.slope_y = static_cast<double>(s.d_dy[0]);
    p.strain_xx = static_cast<double>(s.d_dx[1]);
    p.strain_yy = static_cast<double>(s.d_dy[2]);
    p.strain_xy = 0.5 * static_cast<double>(s.d_dy[1] + s.d_dx[2]);
    return p;
}

} // namespace

float rounded_to_snorm16(float value, float range) {
    if (!(range > 0.0f))
        return 0.0f;
    const float step = range / 32767.0f;
    return std::clamp(std::nearbyint(value / step), -32767.0f, 32767.0f) * step;
}

void round_maps(sea::Keyframe& keyframe, MapFormat format) {
    if (format == MapFormat::f32)
        return;
    for (const sea::Field field : keyframe.fields) {
        const std::span<float> plane = keyframe.plane(field);
        float range = 0;
        for (const float value : plane)
            range = std::max(range, std::abs(value));
        for (float& value : plane)
            value = format == MapFormat::f16 ? rounded_to_half(value)
                                             : rounded_to_snorm16(value, range);
    }
}

sea::HermiteWeights time_weights(TimeRule rule, sea::TimeUs before_us, sea::TimeUs after_us,
                                 sea::TimeUs time_us) {
    const auto span = static_cast<double>(after_us - before_us);
    const double s = span > 0 ? static_cast<double>(time_us - before_us) / span : 0.0;
    switch (rule) {
    case TimeRule::hermite:
        return sea::hermite_weights(before_us, after_us, time_us);
    case TimeRule::linear:
        return {{1 - s, 0, s, 0}, {0, 1 - s, 0, s}};
    case TimeRule::hold:
    case TimeRule::every_frame:
        break;
    }
    return {{1, 0, 0, 0}, {0, 1, 0, 0}};
}

NaiveCascade::Texels NaiveCascade::prepared(sea::KeyframePtr keyframe, SpaceRule space) {
    Texels texels;
    if (space == SpaceRule::spline) {
        texels.spline = std::make_shared<const sea::SplineMap>(*keyframe);
    } else {
        const std::size_t points = keyframe->plane_size();
        const auto fields = static_cast<std::size_t>(keyframe->fields.size());
        texels.values.resize(points * fields);
        for (std::size_t f = 0; f < fields; ++f)
            for (std::size_t i = 0; i < points; ++i)
                texels.values[i * fields + f] = keyframe->values[f * points + i];
    }
    texels.keyframe = std::move(keyframe);
    return texels;
}

NaiveCascade::NaiveCascade(sea::KeyframePtr before, sea::KeyframePtr after, SpaceRule space,
                           TimeRule time)
    : before_(prepared(before, space)), after_(after == before ? before_ : prepared(after, space)),
      space_(space), time_(time) {}

sea::LagrangianPoint NaiveCascade::at(const Texels& texels, double x_m, double y_m) const {
    if (space_ == SpaceRule::spline)
        return spline_point(*texels.spline, x_m, y_m);
    const sea::Keyframe& map = *texels.keyframe;
    const Cell x = cell(x_m, map.length_m, map.size), y = cell(y_m, map.length_m, map.size);
    const auto fields = static_cast<std::size_t>(map.fields.size());
    const auto texel = [&](int ix, int iy) {
        return texels.values.data() +
               (static_cast<std::size_t>(iy) * static_cast<std::size_t>(map.size) +
                static_cast<std::size_t>(ix)) *
                   fields;
    };
    const float* corners[4] = {texel(x.index, y.index), texel(x.next, y.index),
                               texel(x.index, y.next), texel(x.next, y.next)};
    const double weights[4] = {(1 - x.fraction) * (1 - y.fraction), x.fraction * (1 - y.fraction),
                               (1 - x.fraction) * y.fraction, x.fraction * y.fraction};
    sea::LagrangianPoint p;
    std::size_t f = 0;
    for (const sea::Field field : map.fields) {
        double sum = 0;
        for (int c = 0; c < 4; ++c)
            sum += weights[c] * static_cast<double>(corners[c][f]);
        p.*sea::info(field).at_point = sum;
        ++f;
    }
    return p;
}

void NaiveCascade::add(double x_m, double y_m, sea::TimeUs time_us,
                       sea::LagrangianPoint& sum) const {
    const sea::HermiteWeights weights =
        time_weights(time_, before_.keyframe->time_us, after_.keyframe->time_us, time_us);
    const sea::LagrangianPoint a = at(before_, x_m, y_m);
    const sea::LagrangianPoint b =
        time_ == TimeRule::hold || time_ == TimeRule::every_frame ? a : at(after_, x_m, y_m);
    const auto moving = [&](double sea::LagrangianPoint::*value,
                            double sea::LagrangianPoint::*rate) {
        const auto mix = [&](const double(&w)[4]) {
            return w[0] * a.*value + w[1] * a.*rate + w[2] * b.*value + w[3] * b.*rate;
        };
        sum.*value += mix(weights.value);
        sum.*rate += mix(weights.rate);
    };
    using P = sea::LagrangianPoint;
    moving(&P::height, &P::height_rate);
    moving(&P::displacement_x, &P::displacement_x_rate);
    moving(&P::displacement_y, &P::displacement_y_rate);
    // Slopes and strains come without rates: their values alone are mixed.
    for (auto value : {&P::slope_x, &P::slope_y, &P::strain_xx, &P::strain_yy, &P::strain_xy})
        sum.*value += weights.value[0] * a.*value + weights.value[2] * b.*value;
}

sea::Answer fixed_point_answer(const sea::QueryPoint& point, int steps,
                               const sea::Choppiness& choppiness, sea::LagrangianField field) {
    double x_m = point.x_m, y_m = point.y_m;
    sea::LagrangianPoint p = field(x_m, y_m);
    for (int step = 0; step < steps; ++step) {
        x_m = point.x_m - choppiness.x * p.displacement_x;
        y_m = point.y_m - choppiness.y * p.displacement_y;
        p = field(x_m, y_m);
    }
    // Any residual is taken: the first evaluation, which is this point, becomes the answer.
    const auto found = [&p](double, double) { return p; };
    sea::Answer answer =
        sea::surface_at(point, {choppiness, std::numeric_limits<double>::infinity(), {}},
                        sea::LagrangianField(found));
    answer.flags &= ~static_cast<std::uint32_t>(sea::answer_folded);
    return answer;
}

} // namespace seaway::bench
