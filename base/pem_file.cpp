// SPDX-License-Identifier: Apache-2.0
#include "base/pem_file.h"

#include "base/text_file.h"

namespace seaway {

Result<std::string> read_pem_file(const std::string& path) {
    return read_text_file(path, std::size_t{16} << 20);
}

Result<std::string> read_pem_key_file(const std::string& path) {
    SEAWAY_TRY_LET(std::string text, read_pem_file(path));
    for (const char* says : {"-----BEGIN ENCRYPTED", "Proc-Type: 4,ENCRYPTED"})
        if (text.find(says) != std::string::npos)
            return Error{"is encrypted; a key without a pass phrase is needed"};
    return text;
}

} // namespace seaway
