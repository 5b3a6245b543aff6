// SPDX-License-Identifier: Apache-2.0
// Which kernels were fastest: measured once, remembered in a file, and nobody stumbles over that file.
#include <array>
#include <atomic>
#include <cstdlib>
#include <filesystem>
#include <iterator>
#include <thread>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "gpu/call.h"
#include "server/device/kernel_choices.h"
#include "server/device/vulkan_kernel_shelf.h"
#include "server/device/vulkan_synthesizer.h"
#include "tests/gpu/held_drivers.h"
#include "tests/server/device/random_sea.h"
#include "tests/support/folder.h"
#include "tests/support/read_file.h"

namespace seaway::server {
namespace {

using testing::HasSubstr;
using testing::Not;

KernelChoice some(int size, const std::string& design = "T16") {
    return {"a GPU", "driver 1.2", size, size % 256 == 0, 0xbeef, design, 0.000123};
}

TEST(KernelChoices, the_one_that_took_least_time_is_taken) {
    EXPECT_EQ(fastest_of(std::array{3e-5}), 0u);
    EXPECT_EQ(fastest_of(std::array{3e-5, 2e-5, 4e-5}), 1u);
    EXPECT_EQ(fastest_of(std::array{3e-5, 2e-5, 1.9e-5}), 2u);
}

TEST(KernelChoices, are_read_as_they_were_remembered_and_the_last_of_a_kind_counts) {
    const std::string path = tests::folder().file("kept/deep/kernels.tsv");
    EXPECT_THAT(*read_kernel_choices(path), testing::IsEmpty()) << "there is none yet";
    for (const KernelChoice& choice : {some(128), some(256), some(128, "W")})
        ASSERT_TRUE(remember_kernel_choice(path, choice));
    const auto kept = read_kernel_choices(path);
    ASSERT_TRUE(kept) << kept.error().message;
    ASSERT_EQ(kept->size(), 2u);
    const KernelChoice& last = kept->back();
    EXPECT_TRUE(last.is_of_the_same(some(128)));
    EXPECT_EQ(last.design, "W");
    EXPECT_EQ(last.fingerprint, 0xbeefu);
    EXPECT_NEAR(last.seconds, 0.000123, 1e-9);
    EXPECT_TRUE(kept->front().band_limited);
    EXPECT_EQ(kernel_choice_name("a\tb\n"), "a?b?");
}

TEST(KernelChoices, a_file_that_is_none_is_named_and_replaced_by_who_has_measured) {
    const std::string good = "seaway kernels 1\na\tb\t64\tall\t00\tW\t5\n";
    const std::pair<std::string, const char*> rows[] = {
        {"", ""}, // nothing is remembered, and nothing is wrong
        {good, ""},
        {"seaway kernels 0\n", "this version"},
        {"hello", "this version"},
        {good + "a\tb\t64\n", ":3: is damaged"},
        {good.substr(0, good.size() - 4), ":2: is damaged"},
        {good + std::string(100, '\0'), ":3: is damaged"},
        {good + "a\tb\t64\tsome\t00\tW\t5\n", ":3: is damaged"},
        {good + "a\tb\tx\tall\t00\tW\t5\n", ":3: is damaged"},
        {std::string((1 << 20) + 1, 'x'), "more than"}};
    for (const auto& [text, what] : rows) {
        const std::string path = tests::folder().write("odd.tsv", text);
        const auto kept = read_kernel_choices(path);
        EXPECT_EQ(kept.has_value(), *what == 0) << text.substr(0, 60);
        if (!kept) {
            EXPECT_THAT(kept.error().message, HasSubstr(what));
            EXPECT_THAT(kept.error().message, HasSubstr(path));
        }
        ASSERT_TRUE(remember_kernel_choice(path, some(512)));
        const auto mended = read_kernel_choices(path);
        ASSERT_TRUE(mended) << mended.error().message;
        EXPECT_TRUE(mended->back().is_of_the_same(some(512)));
    }
}

TEST(KernelChoices, where_nothing_can_be_written_is_said_and_no_other_file_is_left) {
    const std::string file = tests::folder().write("file", "x");
    for (const std::string& path :
         {file + "/kernels.tsv", std::string("/proc/none/kernels.tsv"), tests::folder().file("")}) {
        const Result<void> kept = remember_kernel_choice(path, some(64));
        ASSERT_FALSE(kept) << path;
    }
    EXPECT_EQ(tests::read_file(file), "x");
}

TEST(KernelChoices, writers_at_one_moment_leave_a_file_that_is_one) {
    const std::string path = tests::folder().file("crowd/kernels.tsv");
    constexpr int rows = 400;
    for (int size = 1; size <= rows; ++size)
        ASSERT_TRUE(remember_kernel_choice(path, some(size)));
    std::vector<std::thread> writers;
    std::atomic<int> wrong = 0;
    for (int w = 0; w < 6; ++w)
        writers.emplace_back([&, w] {
            for (int i = 0; i < 30; ++i) {
                wrong += !remember_kernel_choice(path, some(1 + w)).has_value();
                const auto kept = read_kernel_choices(path);
                wrong += !kept || kept->size() < rows;
            }
        });
    for (std::thread& writer : writers)
        writer.join();
    EXPECT_EQ(wrong, 0) << "reads of a file that was none, or of a part";
    const std::filesystem::directory_iterator files(std::filesystem::path(path).parent_path());
    EXPECT_EQ(std::distance(files, {}), 1) << "and nothing beside it";
}

TEST(KernelChoices, stand_in_the_cache_of_the_user) {
    const char* cache = std::getenv("XDG_CACHE_HOME");
    const char* home = std::getenv("HOME");
    const std::string cache_before = cache ? cache : "", home_before = home ? home : "";
    setenv("XDG_CACHE_HOME", "/var/somewhere", 1);
    EXPECT_EQ(kernel_choices_path(), "/var/somewhere/seaway/kernels.tsv");
    setenv("XDG_CACHE_HOME", "beside", 1);
    setenv("HOME", "/home/a", 1);
    EXPECT_EQ(kernel_choices_path(), "/home/a/.cache/seaway/kernels.tsv");
    unsetenv("XDG_CACHE_HOME");
    EXPECT_EQ(kernel_choices_path(), "/home/a/.cache/seaway/kernels.tsv");
    unsetenv("HOME");
    EXPECT_EQ(kernel_choices_path(), "");
    if (cache)
        setenv("XDG_CACHE_HOME", cache_before.c_str(), 1);
    if (home)
        setenv("HOME", home_before.c_str(), 1);
}

/// Starts with a sea of 128 points; its description.
std::string started(const KernelTuning& tuning) {
    const auto made = make_vulkan_synthesizer({.validation = true, .tuning = tuning});
    EXPECT_TRUE(made) << made.error().message;
    if (!made)
        return "";
    const RandomSea random(128, 200.0, 1);
    const Result<void> set = (*made)->set_sea(random.realization(), 1);
    EXPECT_TRUE(set) << set.error().message;
    EXPECT_THAT((*made)->validation_messages(), testing::IsEmpty());
    return (*made)->description();
}

class Tuning : public testing::Test {
  protected:
    void SetUp() override {
        path_ = tests::folder().file("tuning/kernels.tsv");
        std::filesystem::remove(path_);
    }
    KernelTuning always() const { return {.file = path_, .measure = Measure::always}; }
    /// The choice for 128 points is made this one by hand.
    void set_design(const std::string& design) const {
        auto choices = read_kernel_choices(path_);
        ASSERT_TRUE(choices);
        for (KernelChoice& choice : *choices)
            if (choice.size == 128) {
                choice.design = design;
                ASSERT_TRUE(remember_kernel_choice(path_, choice));
            }
    }
    std::size_t rows() const { return read_kernel_choices(path_).value().size(); }
    KernelChoice choice() const {
        const std::vector<KernelChoice> all = read_kernel_choices(path_).value();
        return *std::ranges::find(all, 128, &KernelChoice::size);
    }
    /// As a description has it: what is taken where nothing is measured or remembered.
    std::string first_that_fits() const {
        return " " + std::string(fitting_transforms(info_, 128, true).front()->design) + ":128";
    }
    const gpu::DeviceInfo& info_ = gpu::tested_device_info();
    std::string path_;
};

TEST_F(Tuning, what_was_measured_once_is_taken_from_the_file_until_somebody_measures_anew) {
    started(always());
    ASSERT_EQ(rows(), 2u) << "of 128 points, and of 64";
    EXPECT_GT(choice().seconds, 0);
    set_design("W");
    EXPECT_THAT(started(always()), HasSubstr(" W:128"));
    EXPECT_THAT(started({.file = path_}), HasSubstr(" W:128")) << "also who does not measure";
    EXPECT_THAT(started({}), HasSubstr(first_that_fits()))
        << "who has no file takes the first that fits";
    KernelTuning anew = always();
    set_design("no such design");
    anew.again = true;
    started(anew);
    EXPECT_NE(choice().design, "no such design");
    EXPECT_EQ(rows(), 2u);
}

TEST_F(Tuning, a_choice_among_other_kernels_or_of_another_driver_is_none) {
    started(always());
    KernelChoice other = choice();
    other.design = "W";
    other.fingerprint ^= 1;
    ASSERT_TRUE(remember_kernel_choice(path_, other));
    EXPECT_THAT(started({.file = path_}), HasSubstr(first_that_fits()));
    other.fingerprint ^= 1;
    std::filesystem::remove(path_);
    other.driver += ", a later one";
    ASSERT_TRUE(remember_kernel_choice(path_, other));
    EXPECT_THAT(started({.file = path_}), HasSubstr(first_that_fits()));
}

TEST_F(Tuning, a_file_that_is_damaged_or_cannot_be_written_is_named_and_no_reason_not_to_start) {
    tests::folder().write("damaged.tsv", "something else");
    const std::string damaged = tests::folder().file("damaged.tsv");
    EXPECT_THAT(started({.file = damaged, .measure = Measure::always}), HasSubstr("damaged.tsv"));
    EXPECT_TRUE(read_kernel_choices(damaged)) << "measured, and written anew";
    EXPECT_THAT(started({.file = damaged, .measure = Measure::always}),
                Not(HasSubstr("damaged.tsv")));
    const std::string nowhere = "/proc/none/kernels.tsv";
    EXPECT_THAT(started({.file = nowhere, .measure = Measure::always}), HasSubstr(nowhere));
}

TEST_F(Tuning, cpus_are_measured_by_who_says_so_alone) {
    started({.file = path_, .measure = Measure::on_gpus});
    EXPECT_EQ(std::filesystem::exists(path_), !info_.is_cpu());
}

// Time is not asserted: what costs any is a call of Vulkan.
TEST_F(Tuning, who_starts_from_the_file_calls_no_more_than_who_has_none) {
    started(always());
    // What others did on the machine meanwhile may have chosen otherwise: each design has calls of its own.
    const std::vector<KernelChoice> measured = read_kernel_choices(path_).value();
    for (KernelChoice one : measured) {
        one.design = fitting_transforms(info_, one.size, one.band_limited).front()->design;
        ASSERT_TRUE(remember_kernel_choice(path_, one));
    }
    const auto calls = [](const KernelTuning& tuning) {
        gpu::fault::arm(~std::uint64_t{0}, VK_ERROR_DEVICE_LOST);
        started(tuning);
        const std::uint64_t count = gpu::fault::calls();
        gpu::fault::disarm();
        return count;
    };
    const std::uint64_t without = calls({});
    EXPECT_EQ(calls(always()), without);
    KernelTuning anew = always();
    anew.again = true;
    EXPECT_GT(calls(anew), without);
}

/// What a driver does at one of its calls while the kernels of 128 points are chosen.
class FailingTuning : public Tuning {
  protected:
    void SetUp() override {
        Tuning::SetUp();
        device_ = std::move(*gpu::Device::create({.validation = true}));
    }
    void TearDown() override {
        gpu::fault::disarm();
        EXPECT_THAT(device_->validation().validation_messages(), testing::IsEmpty());
    }
    struct Chosen {
        Result<const SynthesisKernels*> kernels;
        std::string description;
        std::uint64_t calls;
    };
    /// The `nth` call fails, with `persistent` every later one as well.
    Chosen choose(const KernelTuning& tuning, std::uint64_t nth = never,
                  VkResult result = VK_ERROR_OUT_OF_DEVICE_MEMORY, bool persistent = false) {
        KernelShelf shelf(*device_, false, tuning);
        gpu::fault::arm(nth, result, persistent);
        const Result<const SynthesisKernels*> kernels = shelf.get(128, true);
        const std::uint64_t calls = gpu::fault::calls();
        gpu::fault::disarm();
        return {kernels ? Result<const SynthesisKernels*>(nullptr) : kernels.error(),
                shelf.description(), calls};
    }
    static constexpr std::uint64_t never = ~std::uint64_t{0};
    std::unique_ptr<gpu::Device> device_;
};

TEST_F(FailingTuning, a_design_that_cannot_be_made_or_timed_is_passed_over_and_said_so) {
    const Chosen calm = choose(always());
    ASSERT_TRUE(calm.kernels) << calm.kernels.error().message;
    EXPECT_THAT(calm.description, Not(HasSubstr("VK_ERROR")));
    ASSERT_GT(calm.calls, 100u);
    int passed_over = 0, not_measured = 0;
    // Each is a compilation of all. The step is odd and no multiple of five: a buffer with its view takes five calls.
    const std::uint64_t step = 6 * fitting_transforms(info_, 128, true, true).size() - 1;
    for (std::uint64_t n = 1; n <= calm.calls; n += step) {
        std::filesystem::remove(path_);
        const Chosen chosen = choose(always(), n);
        ASSERT_TRUE(chosen.kernels)
            << "call " << n << " of " << calm.calls << ": " << chosen.kernels.error().message;
        EXPECT_THAT(chosen.description, HasSubstr("VK_ERROR_OUT_OF_DEVICE_MEMORY")) << n;
        const bool one_is_left = chosen.description.find("passed over") != std::string::npos;
        passed_over += one_is_left;
        not_measured += chosen.description.find("not measured") != std::string::npos;
        EXPECT_EQ(std::filesystem::exists(path_), one_is_left)
            << "what was measured is remembered, and nothing else";
    }
    EXPECT_GT(passed_over, 10);
    EXPECT_GT(not_measured, 10);
}

TEST_F(FailingTuning, a_remembered_design_that_cannot_be_made_leaves_its_place_to_the_usual_one) {
    choose(always());
    set_design("W");
    ASSERT_THAT(choose({.file = path_}).description, HasSubstr(" W:128"));
    const Chosen chosen = choose({.file = path_}, 1);
    ASSERT_TRUE(chosen.kernels) << chosen.kernels.error().message;
    EXPECT_THAT(chosen.description, HasSubstr(first_that_fits()));
    EXPECT_THAT(chosen.description, HasSubstr("passed over W"));
}

TEST_F(FailingTuning, a_device_that_is_lost_or_makes_no_design_at_all_is_an_error) {
    const Chosen calm = choose(always());
    for (std::uint64_t n = 1; n <= calm.calls; n += 27) {
        std::filesystem::remove(path_);
        const Chosen lost = choose(always(), n, VK_ERROR_DEVICE_LOST);
        ASSERT_FALSE(lost.kernels) << "call " << n;
        EXPECT_TRUE(lost.kernels.error().is(VK_ERROR_DEVICE_LOST)) << "call " << n;
        EXPECT_FALSE(std::filesystem::exists(path_));
    }
    const Chosen none = choose(always(), 1, VK_ERROR_OUT_OF_DEVICE_MEMORY, true);
    ASSERT_FALSE(none.kernels);
    EXPECT_THAT(none.kernels.error().message, HasSubstr("VK_ERROR_OUT_OF_DEVICE_MEMORY"));
}

} // namespace
} // namespace seaway::server
