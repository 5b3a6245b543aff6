// SPDX-License-Identifier: Apache-2.0
// Certificates that sign themselves, of two days, and their keys, as PEM files.
#pragma once

#include <string>

#include <gtest/gtest.h>

#include "tests/support/folder.h"
#include "tests/support/program.h"

namespace seaway::tests {

/// `names`: who may show it, in OpenSSL's words, such as "DNS:sea.example"; `key`: of which kind. Files that are there are written over.
inline void make_certificate(const std::string& cert_file, const std::string& key_file,
                             const std::string& names = "IP:127.0.0.1",
                             const std::string& key = "ec -pkeyopt ec_paramgen_curve:P-256") {
    const Output made = run_command(
        "openssl req -x509 -nodes -days 2 -subj '/CN=seaway test' -newkey " + key +
        " -addext subjectAltName=" + names + " -keyout " + key_file + " -out " + cert_file);
    EXPECT_EQ(made.status, 0) << made.said();
}

/// Another one each time, in the folder of the test.
struct Certificate {
    explicit Certificate(const std::string& names = "IP:127.0.0.1") {
        make_certificate(cert_file, key_file, names);
    }

    const std::string cert_file = folder().fresh("cert.pem"), key_file = folder().fresh("key.pem");
};

} // namespace seaway::tests
