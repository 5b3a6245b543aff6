// SPDX-License-Identifier: Apache-2.0
// Bytes as a journal that lies in the folder: it is opened and says the same of itself twice, or it is named and left
// as it is.
#include <cstdint>
#include <cstdlib>
#include <filesystem>

#include "server/journal/sqlite_journal.h"
#include "tests/fuzz/scratch_file.h"
#include "tests/support/read_file.h"

using namespace seaway;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const std::string folder = tests::scratch_folder();
    const std::string path = tests::scratch_file("journal.sqlite", data, size);
    for (const char* beside : {"-wal", "-shm", "-journal"})
        std::filesystem::remove(path + beside);
    const server::Beginning beginning{1'700'000'000'000'000, "[sea]\n"};
    const auto journal = server::SqliteJournal::open(folder, beginning);
    if (!journal) {
        if (journal.error().message.find(folder) == std::string::npos)
            std::abort();
        if (tests::read_file(path) != std::string(data, data + size))
            std::abort(); // it was not left as it is
        return 0;
    }
    const auto once = (*journal)->since(0);
    const auto again = (*journal)->since(0);
    if (!once || !again || once->empty() || *once != *again)
        std::abort();
    for (std::size_t i = 0; i < once->size(); ++i)
        if ((*once)[i].epoch != i + 1 || (*once)[i].end_us < (*once)[i].start_us)
            std::abort();
    return 0;
}
