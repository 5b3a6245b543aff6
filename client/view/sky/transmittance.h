// SPDX-License-Identifier: Apache-2.0
// TransmittanceTable: how much light is left on the way from a height to the end of the air.
//
// Optical depths by height and direction in Bruneton's mapping (2017), 256 x 128, of rays that do not
// meet the sea. Depth is what is interpolated, not transmittance: it bends less near the horizon.
// Immutable and thread-safe. Building takes 44 ms of CPU, which threads share, a look-up some 50 ns.
#pragma once

#include <vector>

#include "base/thread_pool.h"
#include "client/view/sky/atmosphere.h"

namespace seaway::client {

/// Work on rows 0 .. count-1, shared by the pool's threads.
template <class Work>
void for_rows(ThreadPool& pool, int count, const Work& work) {
    const Phase phase{
        [](const void* context, int row, int) { (*static_cast<const Work*>(context))(row); }, &work,
        count};
    pool.run({&phase, 1});
}

/// Optical depth by direct integration: the truth that the table interpolates. `steps` may be large.
glm::dvec3 optical_depth(const Air& air, const Ray& ray, double distance_m, int steps);

class TransmittanceTable;

/// The table at one height, for many suns: what hangs on the height alone is found once. Valid as long as the table.
class TransmittanceAt {
  public:
    TransmittanceAt(const TransmittanceTable& table, double height_m);

    /// From there to the top of the air; of a ray that meets the sea, as along the horizon.
    glm::dvec3 to_space(double zenith_cosine) const;
    /// The same for the light of a disc of this radius: what of it is below the horizon is lost.
    glm::dvec3 to_disc(double zenith_cosine, double radius_rad) const;

  private:
    const glm::vec3* below_; ///< the row of the table below
    float above_;            ///< share of the next row
    double radius_m_, top_radius_m_, shortest_m_, longest_m_;
    double lowest_cosine_; ///< of rays that do not meet the sea
    double horizon_cosine_, horizon_sine_;
};

class TransmittanceTable {
  public:
    TransmittanceTable(const Air& air, ThreadPool& pool);

    TransmittanceAt at(double height_m) const { return {*this, height_m}; }
    /// One look-up: TransmittanceAt.
    glm::dvec3 to_space(double height_m, double zenith_cosine) const;
    glm::dvec3 to_disc(double height_m, double zenith_cosine, double radius_rad) const;

    static constexpr int width = 256, height = 128;
    /// Optical depths, [height][direction]: from the sea to the top of the air, from straight up to the horizon.
    const std::vector<glm::vec3>& depths() const { return depth_; }

  private:
    friend class TransmittanceAt;
    Air air_;
    std::vector<glm::vec3> depth_; ///< [height][direction]
};

} // namespace seaway::client
