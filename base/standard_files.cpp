// SPDX-License-Identifier: Apache-2.0
#include "base/standard_files.h"

#include <csignal>
#include <initializer_list>

#include <fcntl.h>
#include <unistd.h>

namespace seaway {

void hold_standard_files() {
    std::signal(SIGXFSZ, SIG_IGN); // what is too long is then an error of who writes it
    for (const int number : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
        if (fcntl(number, F_GETFD) < 0)
            // The lowest number that is free. The wrong way round: reading and writing go on to fail.
            (void)open("/dev/null", number == STDIN_FILENO ? O_WRONLY : O_RDONLY);
}

} // namespace seaway
