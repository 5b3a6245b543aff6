// SPDX-License-Identifier: Apache-2.0
#include "tools/bench/tune/prices.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "base/hash.h"
#include "base/text_file.h"
#include "tools/bench/accuracy/journal.h"
#include "tools/bench/accuracy/measure/measure.h"
#include "tools/bench/accuracy/result_file.h"
#include "tools/bench/accuracy/seas/sea_states.h"

namespace seaway::bench {

namespace {

/// Tiles that hold fewer waves take fewer of Newton's steps: never less than this share of them.
constexpr double steps_least = 0.8;
constexpr int stage_rounds = 9;

/// Which code it is that takes so long: prices of another build say nothing, whatever commit both are of.
const std::string& this_program() {
    constexpr std::size_t bytes_max = std::size_t{1} << 30;
    static const std::string hash = [] {
        const Result<std::string> bytes = read_text_file("/proc/self/exe", bytes_max);
        return bytes ? hex_hash(*bytes) : std::string("unknown");
    }();
    return hash;
}

/// Points that answers are counted at: a few, anywhere.
std::vector<sea::QueryPoint> counted_points() {
    std::mt19937_64 engine(1);
    const auto uniform = [&] {
        return 4000.0 * (2.0 * static_cast<double>(engine() >> 11) * 0x1p-53 - 1.0);
    };
    std::vector<sea::QueryPoint> points(64);
    for (sea::QueryPoint& point : points) {
        point.x_m = uniform();
        point.y_m = uniform();
    }
    return points;
}

/// Mean evaluations an answer; of fewer points where most are searched for sheets, which takes long.
double evaluations_an_answer(const ConfiguredSea& sea) {
    constexpr double evaluations_enough = 2000.0;
    double sum = 0, count = 0;
    for (const sea::QueryPoint& point : counted_points()) {
        sum += sea.evaluations(point);
        count += 1;
        if (sum > evaluations_enough)
            break;
    }
    return sum / count;
}

/// Nanoseconds, or milliseconds where the name says so.
struct SizePrice {
    double keyframe_ms = 0;
    double spline_ms = 0;
    double first_tile_ns = 0; ///< of an evaluation
    double next_tile_ns = 0;
};

struct Stages {
    std::map<int, SizePrice> sizes;
    /// Of encoding for a client that takes predicted tiles: of a point of the cascade's own grid, by way of the smaller
    /// one, and of a byte that is made.
    double sample_ns = 0;
    double byte_ns = 0;
};

class StagePrices final : public Prices {
  public:
    StagePrices(std::string device, std::string file, Place place, Devices& devices)
        : file_(std::move(file)), place_(std::move(place)), devices_(devices),
          costs_(stage_rounds) {
        configuration_.device = std::move(device);
        read();
    }

    Result<Price> at_least(const std::vector<sea::CascadeSpec>& cascades, const sea::Scene& scene,
                           const sea::ErrorBudget* budget) override;
    Result<Price> of(const ConfiguredSea& sea) override;

  private:
    Result<const SizePrice*> size(int size);
    Result<double> evaluation_ns(const std::vector<sea::CascadeSpec>& cascades);
    Result<void> measure_coding();
    Result<std::unique_ptr<ConfiguredSea>> gale(std::vector<sea::CascadeSpec> cascades,
                                                double height_error_m);
    void read();
    Result<void> write() const;

    std::string file_;
    Place place_;
    Devices& devices_;
    StageCosts costs_;
    Configuration configuration_;
    Stages stages_;
    double steps_ = 0; ///< evaluations an answer of this scene takes at least
};

Result<std::unique_ptr<ConfiguredSea>> StagePrices::gale(std::vector<sea::CascadeSpec> cascades,
                                                         double height_error_m) {
    SEAWAY_TRY_LET(const sea::Scene scene, sea_state("gale_deep", 1));
    Configuration configuration = configuration_;
    configuration.cascades = std::move(cascades);
    configuration.height_error_m = height_error_m;
    SEAWAY_TRY_LET(auto sea, ConfiguredSea::create(scene, configuration, devices_));
    SEAWAY_TRY(sea->go_to(1'234'567));
    return sea;
}

Result<const SizePrice*> StagePrices::size(int size) {
    const auto known = stages_.sizes.find(size);
    if (known != stages_.sizes.end())
        return &known->second;
    SizePrice price;
    SEAWAY_TRY_LET(const Stage stage, costs_.keyframe(configuration_, size, devices_));
    price.keyframe_ms = stage.cpu_ms;
    price.spline_ms = costs_.spline_ms(size);
    const auto evaluation_ns = [this](std::vector<sea::CascadeSpec> cascades) -> Result<double> {
        SEAWAY_TRY_LET(const auto sea, gale(std::move(cascades), 0.05));
        return query_ns(*sea, counted_points()).median / evaluations_an_answer(*sea);
    };
    const double longest_m = 8.0 * size, ratio = 2.5;
    SEAWAY_TRY_LET(price.first_tile_ns, evaluation_ns({{longest_m, size}}));
    SEAWAY_TRY_LET(const double three_ns, evaluation_ns({{longest_m, size},
                                                         {longest_m / ratio, size},
                                                         {longest_m / (ratio * ratio), size}}));
    price.next_tile_ns = std::max(0.0, 0.5 * (three_ns - price.first_tile_ns));
    const SizePrice* kept = &(stages_.sizes[size] = price);
    SEAWAY_TRY(write());
    return kept;
}

Result<double> StagePrices::evaluation_ns(const std::vector<sea::CascadeSpec>& cascades) {
    double sum = 0;
    for (std::size_t c = 0; c < cascades.size(); ++c) {
        SEAWAY_TRY_LET(const SizePrice* price, size(cascades[c].size));
        sum += c == 0 ? price->first_tile_ns : price->next_tile_ns;
    }
    return sum;
}

Result<void> StagePrices::measure_coding() {
    if (stages_.sample_ns > 0 || stages_.byte_ns > 0)
        return {};
    // Two bounds, two unknowns.
    std::array<double, 2> ns{}, bytes{};
    for (const std::size_t i : {0u, 1u}) {
        SEAWAY_TRY_LET(const auto sea, gale({{1000.0, 256}}, i == 0 ? 0.3 : 0.003));
        for (int round = 0; round < 4; ++round)
            SEAWAY_TRY(sea->go_to(10'000'000 * round));
        const CodingCost cost = sea->coding(0);
        const double samples = static_cast<double>(cost.keyframes) * 256.0 * 256.0;
        ns[i] = 1e9 * cost.encode_s / samples;
        bytes[i] = static_cast<double>(cost.bytes_made) / samples;
    }
    stages_.byte_ns = std::max(0.0, (ns[1] - ns[0]) / (bytes[1] - bytes[0]));
    stages_.sample_ns = std::max(0.0, ns[0] - bytes[0] * stages_.byte_ns);
    return write();
}

Result<Price> StagePrices::at_least(const std::vector<sea::CascadeSpec>& cascades,
                                    const sea::Scene& scene, const sea::ErrorBudget* budget) {
    Price price;
    SEAWAY_TRY_LET(const std::vector<sea::Band> bands, sea::assign_bands(cascades));
    const sea::Dispersion dispersion = scene.sea.dispersion();
    for (std::size_t c = 0; c < cascades.size(); ++c) {
        SEAWAY_TRY_LET(const SizePrice* stage, size(cascades[c].size));
        // No interval is longer than keyframes can tell the fastest wave, if there is a shorter one.
        const double omega =
            dispersion.omega(std::min(bands[c].k_hi_radpm, scene.sea.wavenumber_max_radpm));
        double interval_s =
            std::clamp(sea::hermite_phase_max / omega,
                       sea::seconds_from_us(*std::rbegin(sea::keyframe_intervals_us)),
                       sea::seconds_from_us(*std::begin(sea::keyframe_intervals_us)));
        if (budget != nullptr && budget->cascades.size() == cascades.size())
            interval_s = sea::seconds_from_us(budget->cascades[c].interval_us);
        price.keyframes_ms += stage->keyframe_ms / interval_s;
        price.splines_ms += stage->spline_ms / interval_s;
    }
    if (!(steps_ > 0)) {
        Configuration balanced = preset_configuration(sea::AccuracyPreset::balanced);
        balanced.device = configuration_.device;
        balanced.height_error_m = 0.001; // nothing is searched for the maps' sake
        if (!scene.effects.choppy)
            balanced.choppiness = 0.0;
        const auto sea = ConfiguredSea::create(scene, balanced, devices_);
        steps_ = 1.0; // where the scene's own waves do not fit these tiles
        if (sea) {
            SEAWAY_TRY((*sea)->go_to(sample_time_us(1)));
            steps_ = steps_least * evaluations_an_answer(**sea);
        }
    }
    SEAWAY_TRY_LET(const double each_ns, evaluation_ns(cascades));
    price.answers_ms = queries_per_s * steps_ * each_ns * 1e-6;
    return price;
}

Result<Price> StagePrices::of(const ConfiguredSea& sea) {
    SEAWAY_TRY(measure_coding());
    Price price;
    std::vector<sea::CascadeSpec> cascades;
    for (std::size_t c = 0; c < sea.waves().used->cascades.size(); ++c) {
        const sea::CascadeSpec& spec = cascades.emplace_back(sea.waves().used->cascades[c].spec);
        const double a_second =
            1.0 / sea::seconds_from_us(sea.waves().budget.cascades[c].interval_us);
        SEAWAY_TRY_LET(const SizePrice* stage, size(spec.size));
        price.keyframes_ms += a_second * stage->keyframe_ms;
        price.splines_ms += a_second * stage->spline_ms;
        const CodingCost coding = sea.coding(c);
        if (coding.keyframes == 0)
            continue;
        const double each = a_second / static_cast<double>(coding.keyframes);
        price.bytes_per_s += each * static_cast<double>(coding.bytes);
        price.encoding_ms += 1e-6 * each * static_cast<double>(coding.bytes_made) * stages_.byte_ns;
        price.encoding_ms +=
            1e-6 * a_second * static_cast<double>(spec.size) * spec.size * stages_.sample_ns;
    }
    SEAWAY_TRY_LET(const double each_ns, evaluation_ns(cascades));
    price.answers_ms = queries_per_s * evaluations_an_answer(sea) * each_ns * 1e-6;
    return price;
}

void StagePrices::read() {
    const Result<std::string> text = read_text_file(file_, 1u << 20);
    const auto json = text ? nlohmann::json::parse(*text, nullptr, false) : nlohmann::json();
    // What another machine or other code took says nothing here; nor does what cannot be read.
    if (!json.is_object() || json.value("machine", "") != place_.machine ||
        json.value("device", "") != place_.device || json.value("program", "") != this_program())
        return;
    const auto number = [](const nlohmann::json& object, const char* key) {
        const auto found = object.find(key);
        return found != object.end() && found->is_number() ? found->get<double>() : 0.0;
    };
    stages_.sample_ns = number(json, "encode_sample_ns");
    stages_.byte_ns = number(json, "encode_byte_ns");
    if (json.contains("sizes") && json["sizes"].is_array())
        for (const auto& row : json["sizes"])
            if (row.is_object())
                stages_.sizes[static_cast<int>(number(row, "size"))] = {
                    number(row, "keyframe_ms"), number(row, "spline_ms"),
                    number(row, "first_tile_ns"), number(row, "next_tile_ns")};
}

Result<void> StagePrices::write() const {
    nlohmann::ordered_json sizes = nlohmann::ordered_json::array();
    for (const auto& [size, price] : stages_.sizes)
        sizes.push_back({{"size", size},
                         {"keyframe_ms", price.keyframe_ms},
                         {"spline_ms", price.spline_ms},
                         {"first_tile_ns", price.first_tile_ns},
                         {"next_tile_ns", price.next_tile_ns}});
    const nlohmann::ordered_json json{
        {"machine", place_.machine},         {"device", place_.device},
        {"program", this_program()},         {"encode_sample_ns", stages_.sample_ns},
        {"encode_byte_ns", stages_.byte_ns}, {"sizes", sizes}};
    return write_result(
        file_, json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + '\n');
}

} // namespace

Result<std::unique_ptr<Prices>> stage_prices(const std::string& device, const std::string& file,
                                             Devices& devices) {
    Configuration configuration;
    configuration.device = device;
    SEAWAY_TRY_LET(Place place, place_of(configuration, devices));
    return std::unique_ptr<Prices>(
        std::make_unique<StagePrices>(device, file, std::move(place), devices));
}

} // namespace seaway::bench
