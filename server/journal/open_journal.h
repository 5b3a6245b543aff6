// SPDX-License-Identifier: Apache-2.0
// Which journal it is: a folder of this machine, or a world's log in NATS. Known here alone.
#pragma once

#include <memory>
#include <string>

#include "base/result.h"
#include "server/journal/journal.h"

namespace seaway::server {

struct JournalPlace {
    std::string option = "--journal"; ///< that says so, for messages
    std::string where;                ///< a folder, or nats://HOST:PORT[,...]/WORLD; empty: none
    // Of NATS (server/journal/nats_place.h):
    std::string tls_ca_file, tls_cert_file, tls_key_file;
    std::string credentials_file;
    int replicas = 1;

    bool is_none() const { return where.empty(); }
};

/// What can be known without asking anybody: the address, and that the files go with one.
Result<void> check_journal_place(const JournalPlace& place);

/// The journal of that place, which begins now if there is none; it follows what others append. While NATS cannot be reached it
/// is asked again for 10 s.
Result<std::unique_ptr<Journal>> open_journal(const JournalPlace& place,
                                              const Beginning& beginning);

} // namespace seaway::server
