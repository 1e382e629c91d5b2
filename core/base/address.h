// core/base/address.h: addresses of volumes on servers, where a path is expected: "https://host/ct.zarr".
#pragma once

#include <filesystem>
#include <string>

namespace tessera {

/// True for "http://...", "https://..." and "s3://...", in any case.
bool isAddress(const std::filesystem::path& path);

/// An address with its scheme in lower case.
std::string withPlainScheme(const std::string& address);

/// An address without what may be secret: user, password, query and fragment.
std::string withoutSecrets(const std::string& address);

/// A path as it is kept in a scene or a manifest, to open again from anywhere: absolute and without ".", or
/// an address without what may be secret.
std::filesystem::path keptPlace(const std::filesystem::path& path);

/// The last part of a path, or of an address without what may be secret: for people.
std::string shownName(const std::filesystem::path& path);

/// A path that a document in `folder` names: absolute and without "."; an address as it is.
std::filesystem::path absolutePlace(const std::filesystem::path& folder, const std::filesystem::path& path);

} // namespace tessera
