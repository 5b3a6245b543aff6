// SPDX-License-Identifier: Apache-2.0
#include "sea/native/native_runner.h"

#include "base/check.h"
#include "base/thread_pool.h"
#include "sea/native/batch.h"

namespace seaway::sea {

struct native::RunnerState {
    explicit RunnerState(int threads) : pool(threads, "sea-synthesis"), batch(pool.threads()) {}
    ThreadPool pool;
    Batch batch;
};

NativeRunner::NativeRunner(int threads) : state_(std::make_unique<native::RunnerState>(threads)) {}
NativeRunner::~NativeRunner() = default;

int NativeRunner::threads() const {
    return state_->pool.threads();
}

ThreadPool& NativeRunner::pool() {
    return state_->pool;
}

FieldSet NativeTask::transformed() const {
    const bool of_strains = fields.contains(Field::jacobian) || !strains.empty();
    return (of_strains ? fields | strain_fields : fields) & linear_fields;
}

void NativeRunner::run(std::span<const NativeTask> tasks) {
    for (const NativeTask& task : tasks) {
        const auto size = static_cast<std::size_t>(task.cascade->size());
        SEAWAY_CHECK(!task.fields.contains(Field::foam), "foam is not synthesised");
        SEAWAY_CHECK(task.planes.size() ==
                         static_cast<std::size_t>(task.fields.size()) * size * size,
                     "planes do not match fields and size");
        SEAWAY_CHECK(task.strains.empty() || task.strains.size() == 3 * size * size,
                     "room for three strains or none");
    }
    state_->pool.run(state_->batch.prepare(tasks));
}

void NativeRunner::trim() {
    state_->batch.trim();
}

std::vector<NativeLines> NativeRunner::run_and_show(const NativeTask& task) {
    run({&task, 1});
    return state_->batch.lines(0);
}

} // namespace seaway::sea
