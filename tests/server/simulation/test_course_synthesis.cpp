// SPDX-License-Identifier: Apache-2.0
// Keyframes of a course of seas from one device: what it is given, and that it makes no difference how much at once.
#include "sea/scene/weather.h"
#include "server/device/native_synthesizer.h"
#include "server/device/vulkan_synthesizer.h"
#include "server/simulation/course_synthesis.h"
#include "tests/server/simulation/simulation_bench.h"

namespace seaway::server {
namespace {

/// A course whose sea glides from 20 to 30 s, and what makes keyframes of it.
struct Course {
    std::shared_ptr<SeaCourse> course;
    std::unique_ptr<CourseSynthesis> synthesis;
    std::uint32_t glide_epoch = 0;

    Course(const std::string& device, const char* path, const char* value) {
        const RunningSeaPtr sea = running_sea();
        course = std::make_shared<SeaCourse>(sea);
        const TomlAssignment one{path, value};
        const Result<sea::Scene> next = sea::changed(sea->scene, {&one, 1});
        EXPECT_TRUE(next) << (next ? "" : next.error().message);
        EXPECT_TRUE(course->add(*next, 20 * second_us, 30 * second_us));
        glide_epoch = course->at(25 * second_us)->epoch;
        Result<std::unique_ptr<RebuiltSynthesizer>> made = RebuiltSynthesizer::start(
            [device](const sea::RealizationPtr& waves, std::uint32_t epoch,
                     server::Making) -> Result<std::unique_ptr<Synthesizer>> {
                std::unique_ptr<Synthesizer> one = std::make_unique<NativeSynthesizer>();
                if (device == "vulkan") {
                    SEAWAY_TRY_LET(one, make_vulkan_synthesizer({}));
                }
                SEAWAY_TRY(one->set_sea(waves, epoch));
                return one;
            },
            sea->realization, sea->epoch, {});
        EXPECT_TRUE(made) << (made ? "" : made.error().message);
        synthesis = std::make_unique<CourseSynthesis>(course, *std::move(made));
    }
    std::vector<NewKeyframePtr> keyframes(std::initializer_list<int> cascades, TimeUs time_us,
                                          FieldSet fields = sea::surface_fields) {
        std::vector<KeyframeRequest> requests;
        for (const int cascade : cascades)
            requests.push_back({cascade, time_us, fields, glide_epoch});
        Result<std::vector<NewKeyframePtr>> made = synthesis->synthesize(requests);
        EXPECT_TRUE(made) << (made ? "" : made.error().message);
        return *std::move(made);
    }
    std::uint64_t taken() const { return synthesis->device().counters().cascades; }
};

class CourseSynthesisOn : public testing::TestWithParam<const char*> {};

// The waves of the moment and what they grow by; where the depth glides, what displacements grow by besides.
TEST_P(CourseSynthesisOn, in_a_glide_the_device_is_given_what_is_asked_for_and_no_other_cascade) {
    for (const auto& [path, value, seas] :
         std::initializer_list<std::tuple<const char*, const char*, unsigned>>{
             {"systems.0.wind_speed_10m_mps", "14.0", 2u}, {"sea.depth_m", "9.0", 3u}}) {
        Course course(GetParam(), path, value);
        const std::uint64_t before = course.taken();
        EXPECT_EQ(before, 2u) << "the sea that it began with";
        for (int n = 1; n <= 5; ++n) {
            course.keyframes({1}, 22 * second_us + n);
            EXPECT_EQ(course.taken() - before, seas * static_cast<unsigned>(n)) << path;
        }
        const std::uint64_t then = course.taken();
        course.keyframes({0, 1}, 25 * second_us);
        EXPECT_EQ(course.taken() - then, 2 * seas) << "both, of one moment";
    }
}

TEST_P(CourseSynthesisOn, maps_of_a_cascade_alone_are_those_that_it_has_beside_others) {
    Course course(GetParam(), "sea.depth_m", "9.0");
    for (const TimeUs time_us : {20 * second_us, 23 * second_us, 30 * second_us}) {
        const std::vector<NewKeyframePtr> together = course.keyframes({0, 1}, time_us);
        for (const int cascade : {1, 0}) {
            const NewKeyframePtr alone = course.keyframes({cascade}, time_us).front();
            const NewKeyframePtr& beside = together[static_cast<std::size_t>(cascade)];
            EXPECT_EQ(alone->cascade, cascade);
            ASSERT_EQ(alone->values.size(), beside->values.size());
            for (std::size_t i = 0; i < alone->values.size(); ++i)
                ASSERT_EQ(alone->values[i], beside->values[i]) << cascade << " " << i;
        }
    }
}

// Naive: the device has been given this moment, so all of it is there. Heights alone have no growth in them, after which the
// moment would be given anew in any case.
TEST_P(CourseSynthesisOn, a_cascade_of_a_moment_that_was_given_without_it_is_given_as_well) {
    Course course(GetParam(), "systems.0.wind_speed_10m_mps", "14.0");
    const FieldSet heights{Field::height};
    const std::vector<NewKeyframePtr> together =
        course.keyframes({0, 1}, 23 * second_us + 1, heights);
    for (const TimeUs time_us : {24 * second_us, 23 * second_us + 1}) // the first is another moment
        for (const int cascade : {1, 0}) {
            const NewKeyframePtr alone = course.keyframes({cascade}, time_us, heights).front();
            EXPECT_EQ(alone->values == together[static_cast<std::size_t>(cascade)]->values,
                      time_us != 24 * second_us)
                << cascade;
        }
}

INSTANTIATE_TEST_SUITE_P(Devices, CourseSynthesisOn, testing::Values("native", "vulkan"),
                         [](const auto& device) { return std::string(device.param); });

} // namespace
} // namespace seaway::server
