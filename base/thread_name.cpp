// SPDX-License-Identifier: Apache-2.0
#include "base/thread_name.h"

#include <pthread.h>

namespace seaway {

void name_thread(const char* name) noexcept {
    (void)pthread_setname_np(pthread_self(), name); // a thread without a name works as well
}

} // namespace seaway
