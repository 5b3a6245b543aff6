// SPDX-License-Identifier: Apache-2.0
// A fuzz target without libFuzzer: each file of the folders given, and each of them changed by lot some times, the
// same on every run. So plain ./dev test goes through the corpus, and a finding that joins it stays found.
//
//     replay_NAME MUTATIONS FOLDER...
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <vector>

#include "tests/fuzz/scratch_file.h"
#include "tests/support/draw.h"
#include "tests/support/read_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace {

using seaway::tests::Draw;
using Bytes = std::vector<std::uint8_t>;

/// A few bits flipped, bytes set to the ends of what they can be, pieces left out, doubled or cut off.
Bytes changed(Bytes bytes, Draw& draw) {
    for (std::uint64_t changes = 1 + draw.below(6); changes > 0 && !bytes.empty(); --changes) {
        const auto at = static_cast<std::ptrdiff_t>(draw.below(bytes.size()));
        const auto end = at + static_cast<std::ptrdiff_t>(
                                  draw.below(bytes.size() - static_cast<std::size_t>(at)));
        switch (draw.below(6)) {
        case 0:
        case 1:
            bytes[static_cast<std::size_t>(at)] ^= static_cast<std::uint8_t>(1u << draw.below(8));
            break;
        case 2:
            bytes[static_cast<std::size_t>(at)] =
                draw.one_of<std::uint8_t>({0, 1, 0x7f, 0x80, 0xff});
            break;
        case 3:
            bytes.erase(bytes.begin() + at, bytes.begin() + std::min(end, at + 16));
            break;
        case 4: {
            const Bytes piece(bytes.begin() + at, bytes.begin() + std::min(end, at + 64));
            bytes.insert(bytes.begin() + at, piece.begin(), piece.end());
            break;
        }
        default:
            if (draw.below(4) == 0)
                bytes.resize(static_cast<std::size_t>(at));
        }
    }
    return bytes;
}

/// Kept where it is if the process ends in it.
void run(const Bytes& bytes) {
    seaway::tests::scratch_file("last_input", bytes.data(), bytes.size());
    (void)LLVMFuzzerTestOneInput(bytes.data(), bytes.size());
}

} // namespace

int main(int argc, char** argv) {
    if (argc < 3) {
        std::fprintf(stderr, "usage: %s MUTATIONS FOLDER...\n", argv[0]);
        return 2;
    }
    const int mutations = std::atoi(argv[1]);
    std::printf("each input lies in %s/last_input while it is tried\n",
                seaway::tests::scratch_folder().c_str());
    std::fflush(stdout);
    int files = 0;
    for (int i = 2; i < argc; ++i) {
        std::vector<std::filesystem::path> paths;
        for (const auto& entry : std::filesystem::directory_iterator(argv[i]))
            paths.push_back(entry.path());
        std::sort(paths.begin(), paths.end());
        for (const auto& path : paths) {
            const std::string text = seaway::tests::read_file(path);
            const Bytes bytes(text.begin(), text.end());
            Draw draw(static_cast<std::uint64_t>(++files));
            run(bytes);
            for (int n = 0; n < mutations; ++n)
                run(changed(bytes, draw));
        }
    }
    std::printf("%d files, each %d times changed\n", files, mutations);
    return files > 0 ? 0 : 1;
}
