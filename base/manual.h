// SPDX-License-Identifier: Apache-2.0
// What a program says of its options, in the forms that systems keep beside it: a page of the manual (man(7)) and
// completion for bash. Both are made of what --help is made of; nothing is said twice.
//
// Pure; thread-safe. Any program writes its own: `seaway-query --manual`, `seaway-query --completion`.
#pragma once

#include <string>

namespace CLI {
class App;
} // namespace CLI

namespace seaway {

/// Section 1, with the macros of man(7). `version`: what stands at the foot of the page.
std::string manual_page(const CLI::App& app, const std::string& version);

/// A function for bash and the `complete` that names it: options, commands, words that an option takes
/// ("table|json|csv", or what one_of() allows) and names of files where it takes FILE or DIR.
std::string bash_completion(const CLI::App& app);

} // namespace seaway
