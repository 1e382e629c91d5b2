// bricking/import/files/stack/xml_tags.h: the tags of an XML text, one after another, and their attributes.
// Private to stacks.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace tessera {

/// Views of the text.
struct XmlTag {
    std::string_view name;             // without its namespace
    std::string_view attributes;       // as they are written
    std::string_view text;             // behind it, up to the next tag
    bool opens = true, closes = false; // an element without content does both
};

/// Comments, instructions and declarations are passed over. A text that was cut gives the tags that are
/// whole.
std::vector<XmlTag> xmlTagsOf(std::string_view text);

/// The value of an attribute, its entities replaced; "" none.
std::string xmlAttribute(const XmlTag& tag, std::string_view key);

} // namespace tessera
