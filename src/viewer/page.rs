//! The page: a single file, assembled from parts that are embedded in the program.

const HTML: &str = include_str!("page/page.html");
const STYLE: &str = include_str!("page/style.css");
const SCRIPTS: [&str; 5] = [
    include_str!("page/camera.js"),
    include_str!("page/link.js"),
    include_str!("page/fields.js"),
    include_str!("page/timeline.js"),
    include_str!("page/main.js"),
];

/// The page, whose script a browser runs only with this nonce.
pub fn html(nonce: &str) -> String {
    HTML.replace("{{style}}", STYLE)
        .replace("{{script}}", &SCRIPTS.concat())
        .replace("{{nonce}}", nonce)
}

/// The content security policy: no foreign resources, and only the page's own script.
pub fn policy(nonce: &str) -> String {
    format!(
        "default-src 'none'; script-src 'nonce-{nonce}'; style-src 'nonce-{nonce}'; img-src blob: data:; \
         connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
    )
}
