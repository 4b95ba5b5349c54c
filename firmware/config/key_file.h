// The pre-shared key of hosts and controller, from a file that only its owner may read.
#pragma once

#include <string>

#include "shared/wire/secure_channel.h"

namespace sanso::firmware {

/// Reads 64 hexadecimal digits from `path`. False: `error` says what is wrong and what to do: no
/// such file, readable by others, not a key, or a key of zeros.
bool read_key_file(const std::string& path, wire::Key& key, std::string& error);

}  // namespace sanso::firmware
