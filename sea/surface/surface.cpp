// SPDX-License-Identifier: Apache-2.0
#include "sea/surface/surface.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <memory>
#include <new>
#include <utility>

#include "base/recycled.h"
#include "sea/surface/by_time.h"
#include "sea/surface/maps/hermite.h"
#include "sea/surface/steepness.h"
#include "sea/surface/surface_at_time.h"

namespace seaway::sea {

namespace {

constexpr std::size_t answered_at_once = 2 * PointBlock::size;

void add(LagrangianPoint& sum, const HermiteWeights& weights, const SplineSample& a,
         const SplineSample& b) {
    using spline_channel::height, spline_channel::displacement_x, spline_channel::displacement_y,
        spline_channel::rate;
    using Channels = float[spline_channel::count];
    const auto mix = [](const double(&w)[4], const Channels& pa, const Channels& pb, int c) {
        return w[0] * static_cast<double>(pa[c]) + w[1] * static_cast<double>(pa[c + rate]) +
               w[2] * static_cast<double>(pb[c]) + w[3] * static_cast<double>(pb[c + rate]);
    };
    sum.height += mix(weights.value, a.value, b.value, height);
    sum.displacement_x += mix(weights.value, a.value, b.value, displacement_x);
    sum.displacement_y += mix(weights.value, a.value, b.value, displacement_y);
    sum.height_rate += mix(weights.rate, a.value, b.value, height);
    sum.displacement_x_rate += mix(weights.rate, a.value, b.value, displacement_x);
    sum.displacement_y_rate += mix(weights.rate, a.value, b.value, displacement_y);
    sum.slope_x += mix(weights.value, a.d_dx, b.d_dx, height);
    sum.slope_y += mix(weights.value, a.d_dy, b.d_dy, height);
    sum.strain_xx += mix(weights.value, a.d_dx, b.d_dx, displacement_x);
    sum.strain_yy += mix(weights.value, a.d_dy, b.d_dy, displacement_y);
    sum.strain_xy += 0.5 * (mix(weights.value, a.d_dy, b.d_dy, displacement_x) +
                            mix(weights.value, a.d_dx, b.d_dx, displacement_y));
}

std::uint64_t next_number() {
    static std::atomic<std::uint64_t> last = 0;
    return ++last;
}

/// What is solved together.
struct Batch {
    std::array<PointBlock, 2> blocks;
    std::array<std::size_t, answered_at_once> point_of; ///< by place in the blocks
    std::size_t count = 0;

    void add(std::size_t which, const QueryPoint& point, const PointWeights* weights,
             const PointMemory& last, double reach_m) {
        PointBlock& block = blocks[count / PointBlock::size];
        const std::size_t lane = count % PointBlock::size;
        block.x_m[lane] = point.x_m;
        block.y_m[lane] = point.y_m;
        block.weights[lane] = weights;
        // Where no point comes from nothing is looked up: not a number is further than that, too.
        block.warm[lane] = last.known && std::hypot(last.shift_x_m, last.shift_y_m) <= reach_m;
        block.shift_x_m[lane] = last.shift_x_m;
        block.shift_y_m[lane] = last.shift_y_m;
        block.count = static_cast<int>(lane) + 1;
        point_of[count++] = which;
    }
    const PointBlock& block_of(std::size_t k) const { return blocks[k / PointBlock::size]; }
};

/// By linear theory the water's own: choppiness moves the picture's points.
void put_velocity(const PointBlock& points, std::size_t p, Answer& answer) {
    using namespace spline_channel;
    answer.velocity_mps[0] = static_cast<double>(points.rate[p][displacement_x]);
    answer.velocity_mps[1] = static_cast<double>(points.rate[p][displacement_y]);
    answer.velocity_mps[2] = static_cast<double>(points.rate[p][height]);
}

double interval_s(const SplinePair& pair) {
    return seconds_from_us(pair.after->time_us() - pair.before->time_us());
}

} // namespace

Surface::Surface(std::span<const SplinePair> pairs, Choppiness choppiness, FoldSearch folds,
                 const MapError& error, double tolerance_m)
    : number_(next_number()), choppiness_(choppiness), folds_(folds), error_(error),
      tolerance_m_(tolerance_m), sideways_(choppiness.largest()) {
    SEAWAY_CHECK(pairs.size() <= surface_pairs_max, "a surface has 16 cascades at most");
    for (const SplinePair& pair : pairs)
        pairs_.push_back(pair);
    SEAWAY_CHECK(error_.cascades.empty() || error_.cascades.size() == pairs_.size(),
                 "one loss a cascade");
    for (const SplinePair& pair : pairs_) {
        SEAWAY_CHECK(pair.before && pair.after, "a surface needs both maps of every cascade");
        SEAWAY_CHECK(pair.before->size() == pair.after->size(), "a pair is of one cascade");
        moves_sideways_ =
            moves_sideways_ && pair.before->moves_sideways() && pair.after->moves_sideways();
    }
    double displacement_m2 = 0;
    for (std::size_t c = 0; c < error_.cascades.size(); ++c)
        displacement_m2 +=
            error_.cascades[c].displacement.largest_variance_m2(interval_s(pairs_[c]));
    fold_blur_m_ =
        sideways_ * (fold_sigmas * std::sqrt(displacement_m2) + error_.displacement_bound_m);
    fold_strain_blur_ = sideways_ * error_.strain_bound + error_.codec_strain_bound;
    flat_height_bound_m_ = height_bound_m(0.0);
    for (const SplinePair& pair : pairs_) {
        const SplineMap& map = *pair.before;
        tiles_.push_back({map.coefficients().data(), pair.after->coefficients().data(),
                          map.length_m(), static_cast<double>(map.size()),
                          map.size() / map.length_m(),
                          (map.size() + SplineMap::border) * SplineMap::channels});
    }
}

double Surface::height_bound_m(double slope) const {
    return largest_height_bound_m(error_, slope * sideways_,
                                  [&](std::size_t c) { return interval_s(pairs_[c]); });
}

Surface::AtTime::AtTime(const Surface& surface, TimeUs time)
    : time_us(time), sheets(surface, time), flags(surface.lasting_flags(time)) {
    for (std::size_t c = 0; c < surface.pairs_.size(); ++c) {
        const HermiteWeights& w = sheets.weights(c);
        for (int i = 0; i < 4; ++i) {
            weights[c].value[i] = static_cast<float>(w.value[i]);
            weights[c].rate[i] = static_cast<float>(w.rate[i]);
        }
    }
    for (std::size_t c = 0; c < surface.error_.cascades.size(); ++c) {
        const SplinePair& pair = surface.pairs_[c];
        const double interval = interval_s(pair);
        const double since = seconds_from_us(time - pair.before->time_us());
        // Of one map alone the interval is not known, but how long it runs on.
        double share = since == 0 ? 0.0 : 1 + std::abs(since) / hermite_beyond_alone_s;
        if (interval > 0)
            share = since / interval;
        const CascadeLoss& loss = surface.error_.cascades[c];
        losses[c] = {loss.height.at(share, sheets.weights(c)),
                     loss.displacement.at(share, sheets.weights(c)),
                     pair.before->size() / pair.before->length_m()};
    }
}

/// The last few times, made when they are first asked for. One more than a block has, so that the last one of a block is
/// there for the next.
class Surface::TimesOfBlock {
  public:
    explicit TimesOfBlock(const Surface& surface)
        : surface_(surface), room_(places * sizeof(AtTime) + alignof(AtTime)) {
        void* first = room_.data();
        std::size_t bytes = room_.size();
        first_ = static_cast<std::byte*>(
            std::align(alignof(AtTime), places * sizeof(AtTime), first, bytes));
    }
    ~TimesOfBlock() {
        while (made_-- > 0)
            place(made_)->~AtTime();
    }
    TimesOfBlock(const TimesOfBlock&) = delete;
    TimesOfBlock& operator=(const TimesOfBlock&) = delete;

    const AtTime& at(TimeUs time_us) {
        if (made_ > 0 && place(last_)->time_us == time_us)
            return *place(last_);
        last_ = made_ < places ? made_ : (last_ + 1) % places;
        if (made_ < places)
            ++made_;
        else
            place(last_)->~AtTime();
        return *::new (first_ + last_ * sizeof(AtTime)) AtTime(surface_, time_us);
    }

  private:
    static constexpr std::size_t places = answered_at_once + 1;
    AtTime* place(std::size_t n) {
        return std::launder(reinterpret_cast<AtTime*>(first_ + n * sizeof(AtTime)));
    }

    const Surface& surface_;
    std::size_t made_ = 0;
    std::size_t last_ = 0;
    RecycledVector<std::byte> room_; ///< too much for the stacks that engines give their jobs
    std::byte* first_;
};

std::uint32_t Surface::lasting_flags(TimeUs time_us) const {
    return (covers(time_us) ? 0u : answer_extrapolated) |
           (moves_sideways_ ? 0u : answer_vertical_velocity);
}

LagrangianPoint Surface::at(double x_m, double y_m, TimeUs time_us) const {
    struct Cells {
        SplineMap::Cell before;
        SplineMap::Cell after;
    };
    std::array<Cells, surface_pairs_max> cells;
    for (std::size_t c = 0; c < pairs_.size(); ++c)
        cells[c] = {pairs_[c].before->cell(x_m, y_m), pairs_[c].after->cell(x_m, y_m)};
    LagrangianPoint sum;
    for (std::size_t c = 0; c < pairs_.size(); ++c) {
        const SplinePair& pair = pairs_[c];
        const HermiteWeights weights =
            hermite_weights(pair.before->time_us(), pair.after->time_us(), time_us);
        const SplineSample before = pair.before->sample(cells[c].before);
        const bool single = pair.before == pair.after;
        add(sum, weights, before, single ? before : pair.after->sample(cells[c].after));
    }
    return sum;
}

bool Surface::covers(TimeUs time_us) const {
    return std::all_of(pairs_.begin(), pairs_.end(), [&](const SplinePair& pair) {
        return pair.before->time_us() <= time_us && time_us <= pair.after->time_us();
    });
}

Answer Surface::careful(const QueryPoint& point, const AtTime& then, ErrorTerms* terms) const {
    SurfaceSheets sheets = then.sheets; // a search leaves its patches there
    const InverseOptions options{choppiness_, tolerance_m_, folds_, error_.curvature_per_m};
    const auto field = [&](double x_m, double y_m) { return at(x_m, y_m, point.time_us); };
    Vec2 lagrangian{point.x_m, point.y_m};
    Answer answer = surface_at(point, options, field, &sheets, &lagrangian);
    if (answer.flags & answer_invalid) {
        if (terms != nullptr)
            *terms = {};
        return answer;
    }
    const auto between = [&](std::size_t c) {
        const double cells_a_metre = then.losses[c].cells_a_metre;
        const auto along = [&](double place_m) {
            const double cells = place_m * cells_a_metre;
            return between_samples(cells - std::floor(cells));
        };
        return Between<double>{along(lagrangian.x), along(lagrangian.y)};
    };
    const double sideways = surface_slope(answer) * sideways_;
    if (terms != nullptr) {
        *terms = terms_of(between, then, sideways);
        terms->inverse_m = answer.error_m;
    }
    answer.error_m += height_bound_m<double>(between, then, sideways);
    answer.flags |= then.flags;
    return answer;
}

void Surface::answer_block(std::span<const QueryPoint> points, std::span<Answer> answers,
                           const Answering& how, const PointKernel& kernel,
                           std::span<const PointTile> tiles,
                           std::span<const AtTime* const> then) const {
    const auto terms = [&](std::size_t i) { return how.terms.empty() ? nullptr : &how.terms[i]; };
    const double reach_m = 2 * folds_.reach_m;
    Batch batch;
    std::array<const AtTime*, answered_at_once> then_of;
    std::array<Answer*, answered_at_once> answer_of;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const QueryPoint& point = points[i];
        if (!std::isfinite(point.x_m) || !std::isfinite(point.y_m) || tiles_.empty()) {
            answers[i] = careful(point, *then[i], terms(i));
            continue;
        }
        then_of[batch.count] = then[i];
        answer_of[batch.count] = &answers[i];
        batch.add(i, point, then[i]->weights.data(),
                  how.memory.empty() ? PointMemory{} : how.memory[i], reach_m);
    }
    if (batch.count == 0)
        return;
    kernel.solve({tiles.data(), static_cast<int>(tiles.size()), choppiness_.x, choppiness_.y,
                  tolerance_m_, reach_m, how.parts == AnswerParts::all},
                 batch.blocks[0], batch.blocks[1].count > 0 ? &batch.blocks[1] : nullptr);
    std::array<SurfaceSheets::Cells, answered_at_once> cells;
    for (std::size_t k = 0; k < batch.count; ++k) {
        const PointBlock& block = batch.block_of(k);
        const std::size_t p = k % PointBlock::size;
        for (std::size_t c = 0; c < tiles_.size(); ++c)
            cells[k][c] = {block.cell_x[c][p], block.cell_y[c][p]};
        if (block.solved[p])
            then_of[k]->sheets.fetch(cells[k]);
    }
    for (std::size_t b = 0; b < batch.blocks.size(); ++b)
        gentle(batch.blocks[b], &then_of[b * PointBlock::size], &answer_of[b * PointBlock::size]);
    for (std::size_t k = 0; k < batch.count; ++k) {
        const PointBlock& block = batch.block_of(k);
        const std::size_t p = k % PointBlock::size;
        const std::size_t i = batch.point_of[k];
        const Vec2 target{points[i].x_m, points[i].y_m};
        const Vec2 root{target.x + block.shift_x_m[p], target.y + block.shift_y_m[p]};
        const bool settled = block.solved[p] && then_of[k]->sheets.single(target, root, cells[k]);
        if (!settled)
            answers[i] = careful(points[i], *then_of[k], terms(i));
        else if (how.parts == AnswerParts::all)
            put_velocity(block, p, answers[i]);
        if (settled && terms(i) != nullptr)
            *terms(i) = gentle_terms(block, p, *then_of[k], answers[i]);
        if (!how.memory.empty())
            how.memory[i] = {block.shift_x_m[p], block.shift_y_m[p], settled};
        if (how.parts == AnswerParts::height)
            leave_out_velocity(answers[i]);
    }
}

void Surface::answer(std::span<const QueryPoint> points, std::span<Answer> answers,
                     const Answering& how, const PointKernel& kernel) const {
    SEAWAY_CHECK(points.size() == answers.size(), "one answer a point");
    SEAWAY_CHECK(how.memory.empty() || how.memory.size() == points.size(), "one memory a point");
    SEAWAY_CHECK(how.terms.empty() || how.terms.size() == points.size(), "terms of each point");
    TimesOfBlock times(*this);
    const auto answer_some = [&](std::size_t first, std::size_t end,
                                 std::span<const PointTile> tiles) {
        while (first < end) {
            const std::size_t count = std::min(answered_at_once, end - first);
            std::array<const AtTime*, answered_at_once> then;
            for (std::size_t i = 0; i < count; ++i)
                then[i] = &times.at(points[first + i].time_us);
            Answering some = how;
            if (!how.memory.empty())
                some.memory = how.memory.subspan(first, count);
            if (!how.terms.empty())
                some.terms = how.terms.subspan(first, count);
            answer_block(points.subspan(first, count), answers.subspan(first, count), some, kernel,
                         tiles, {then.data(), count});
            first += count;
        }
    };
    const std::span<const PointTile> unmixed(tiles_.data(), tiles_.size());
    std::size_t begun = 0; // of those that nothing is mixed for
    for (std::size_t first = 0; how.mixed != nullptr && first < points.size();) {
        const std::size_t end = same_time_end(points, first);
        MixedMaps::Lent lent;
        // What to keep count of it costs is nothing to a block.
        if (end - first >= PointBlock::size || points.size() == 1)
            how.mixed->lend(*this, points[first].time_us, end - first, kernel, lent);
        if (lent) {
            answer_some(begun, first, unmixed);
            ShortList<PointTile, surface_pairs_max> tiles = tiles_;
            for (std::size_t c = 0; c < tiles.size(); ++c)
                tiles[c].mixed = lent.map(c);
            answer_some(first, end, {tiles.data(), tiles.size()});
            begun = end;
        }
        first = end;
    }
    answer_some(begun, points.size(), unmixed);
}

void Surface::mix(TimeUs time_us, const PointKernel& kernel,
                  std::span<const AlignedFloats> maps) const {
    const AtTime then(*this, time_us);
    for (std::size_t c = 0; c < pairs_.size(); ++c)
        kernel.mix(tiles_[c], then.weights[c], pairs_[c].before->texels(), maps[c].get());
}

void Surface::answer(std::span<const QueryPoint> points, std::span<Answer> answers,
                     const Answering& how) const {
    static const PointKernel& best = point_kernel(best_instructions());
    answer(points, answers, how, best);
}

Answer Surface::answer(const QueryPoint& point) const {
    Answer answer;
    this->answer({&point, 1}, {&answer, 1});
    return answer;
}

Answer Surface::answer_carefully(const QueryPoint& point) const {
    const AtTime then(*this, point.time_us);
    return careful(point, then, nullptr);
}

const PointKernel& point_kernel(Instructions instructions) {
#if defined(SEAWAY_X86)
    if (instructions == Instructions::avx512)
        return point_kernel_avx512();
    if (instructions == Instructions::avx2)
        return point_kernel_avx2();
#else
    SEAWAY_CHECK(instructions == Instructions::portable, "no other kernel is built");
#endif
    return point_kernel_portable();
}

} // namespace seaway::sea
