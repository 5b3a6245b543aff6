// SPDX-License-Identifier: Apache-2.0
// What our own warnings would refuse, in a program that uses our headers.
#include "client/client.h"
#include "client/seaway.h"

int main(int argc, char**) {
    const seaway::client::Asking asking{};
    int unused = (int)sizeof(asking);
    for (int argc = 0; argc < 1; ++argc)
        continue;
    return argc == 1 ? 0 : 1;
}
