//! A viewer that runs, and a page of it without a browser.

use std::{
    io::{BufRead, BufReader, Read, Write},
    net::TcpStream,
    process::{Child, Stdio},
    time::Duration,
};

use serde_json::{Value, json};
use tungstenite::{Message, WebSocket, client::IntoClientRequest, http::HeaderValue};

use crate::common::{Folder, SMALL_SCENE};

/// Longer than anything takes; no test waits for it to pass.
const PATIENCE: Duration = Duration::from_secs(120);

/// A running viewer.
pub struct Fly {
    pub folder: Folder,
    child: Child,
    pub address: String,
    pub key: String,
}

impl Fly {
    /// A viewer of the small scene and its path `path.csv`.
    pub fn start(path: Option<&str>, args: &[&str]) -> Self {
        let path = path.map(|text| ("path.csv", text));
        Self::of(SMALL_SCENE, path.as_slice(), args)
    }

    /// A viewer of a scene file and those beside it.
    pub fn of(scene: &str, beside: &[(&str, &str)], args: &[&str]) -> Self {
        let files = [&[("scene.toml", scene)], beside].concat();
        Self::of_files(&files, args)
    }

    /// A viewer of the first of these files.
    pub fn of_files(files: &[(&str, &str)], args: &[&str]) -> Self {
        let folder = Folder::new();
        for (name, text) in files {
            folder.write(name, text);
        }
        let mut child = folder
            .program_with_signals()
            .args(["fly", files[0].0, "--frames", "path.csv", "-o", "job.####.png"])
            .args(args)
            .stdout(Stdio::piped())
            .spawn()
            .expect("the program starts");
        let mut line = String::new();
        let stdout = child.stdout.take().expect("it is piped");
        BufReader::new(stdout).read_line(&mut line).expect("a line");
        let (address, key) = line.trim().split_once("/?key=").expect("an address with a key");
        Self {
            address: address.strip_prefix("http://").expect("an address").to_owned(),
            key: key.to_owned(),
            folder,
            child,
        }
    }

    pub fn connect(&self) -> TcpStream {
        let stream = TcpStream::connect(&self.address).expect("it listens");
        stream.set_read_timeout(Some(PATIENCE)).expect("a timeout");
        stream
    }

    /// The answer to a request for `path`, with these headers: the status, the headers and the body.
    pub fn get(&self, path: &str, headers: &[(&str, &str)]) -> (u16, String, Vec<u8>) {
        let mut stream = self.connect();
        let headers: String = headers
            .iter()
            .map(|(name, value)| format!("{name}: {value}\r\n"))
            .collect();
        write!(stream, "GET {path} HTTP/1.1\r\n{headers}Connection: close\r\n\r\n").expect("sent");
        let mut answer = Vec::new();
        stream.read_to_end(&mut answer).expect("an answer");
        let end = answer
            .windows(4)
            .position(|w| w == b"\r\n\r\n")
            .expect("an end of the headers");
        let head = String::from_utf8(answer[..end].to_vec()).expect("text");
        let status = head.split(' ').nth(1).and_then(|s| s.parse().ok()).expect("a status");
        (status, head.to_lowercase(), answer[end + 4..].to_vec())
    }

    pub fn own(&self, path: &str) -> (u16, String, Vec<u8>) {
        self.get(&format!("{path}?key={}", self.key), &[("Host", &self.address)])
    }

    /// A page, or the status with which its connection was refused.
    pub fn page_of(&self, host: &str, origin: Option<&str>, key: &str) -> Result<Page, u16> {
        let uri = format!("ws://{host}/live?key={key}");
        let mut request = uri.into_client_request().expect("an address");
        if let Some(origin) = origin {
            let origin = HeaderValue::from_str(origin).expect("an origin");
            request.headers_mut().insert("Origin", origin);
        }
        match tungstenite::client(request, self.connect()) {
            Ok((socket, _)) => Ok(Page {
                socket,
                seq: 0,
                client: 0,
                hello: Value::Null,
                facts: Value::Null,
                keys: Vec::new(),
            }),
            Err(tungstenite::HandshakeError::Failure(tungstenite::Error::Http(answer))) => {
                Err(answer.status().as_u16())
            }
            Err(other) => panic!("{other}"),
        }
    }

    pub fn page(&self) -> Page {
        let origin = format!("http://{}", self.address);
        let mut page = self.page_of(&self.address, Some(&origin), &self.key).expect("let in");
        page.hello = page.told("hello");
        page.client = page.hello["client"].as_u64().expect("a number");
        page.facts = page.told("facts");
        page.told("keys");
        page
    }

    pub fn still(&self) -> Vec<u8> {
        let (status, _, file) = self.own("/still.png");
        assert_eq!(status, 200);
        file
    }

    /// Sends SIGINT. Returns the exit code.
    #[cfg(unix)]
    pub fn interrupt(&mut self) -> Option<i32> {
        let sent = std::process::Command::new("kill")
            .args(["-INT", &self.child.id().to_string()])
            .status();
        assert!(sent.expect("kill runs").success());
        self.child.wait().expect("it ends").code()
    }
}

impl Drop for Fly {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// A page without a browser.
pub struct Page {
    pub socket: WebSocket<TcpStream>,
    seq: u64,
    client: u64,
    /// The first message to it.
    pub hello: Value,
    /// Those that it was told first.
    pub facts: Value,
    /// Those of the timeline.
    pub keys: Vec<Value>,
}

/// A message of the viewer.
pub enum Told {
    Facts(Value),
    Picture(Value, Vec<u8>),
    /// The connection has ended, with the code of a close.
    End(Option<u16>),
}

impl Page {
    pub fn send(&mut self, message: &Value) {
        self.socket.send(Message::text(message.to_string())).expect("sent");
    }

    /// Sends a message that changes the view.
    pub fn ask(&mut self, mut message: Value) {
        self.seq += 1;
        message["seq"] = json!(self.seq);
        self.send(&message);
    }

    pub fn next(&mut self) -> Told {
        let told = self.read();
        if let Told::Picture(header, _) = &told
            && header["kind"] == "view"
        {
            self.send(&json!({ "t": "ack" }));
        }
        if let Told::Facts(change) = &told
            && change["t"] == "keys"
        {
            let index = |name: &str| change[name].as_u64().expect("a number") as usize;
            let insert = change["insert"].as_array().expect("keys").iter().cloned();
            self.keys.splice(index("at")..index("at") + index("remove"), insert);
        }
        told
    }

    /// The next message, which is not answered.
    fn read(&mut self) -> Told {
        match self.socket.read() {
            Ok(Message::Text(text)) => Told::Facts(serde_json::from_str(&text).expect("JSON")),
            Ok(Message::Binary(bytes)) => {
                let size = u32::from_le_bytes(bytes[..4].try_into().expect("four bytes")) as usize;
                let header: Value = serde_json::from_slice(&bytes[4..4 + size]).expect("JSON");
                Told::Picture(header, bytes[4 + size..].to_vec())
            }
            Ok(Message::Close(frame)) => Told::End(frame.map(|f| f.code.into())),
            Ok(_) => self.read(),
            Err(_) => Told::End(None),
        }
    }

    /// The next message of this kind.
    pub fn told(&mut self, kind: &str) -> Value {
        loop {
            match self.next() {
                Told::Facts(facts) if facts["t"] == kind => return facts,
                Told::End(code) => panic!("the connection has ended: {code:?}"),
                _ => {}
            }
        }
    }

    /// The first picture of what was asked for last, or with `is_final` the last one.
    pub fn picture(&mut self, is_final: bool) -> (Value, Vec<u8>) {
        loop {
            match self.next() {
                Told::Picture(header, file)
                    if header["client"] == self.client
                        && header["seq"] == self.seq
                        && (!is_final || header["stage"] == "final") =>
                {
                    return (header, file);
                }
                Told::End(code) => panic!("the connection has ended: {code:?}"),
                _ => {}
            }
        }
    }

    /// The code with which the connection ends.
    pub fn end(&mut self) -> Option<u16> {
        loop {
            if let Told::End(code) = self.read() {
                return code;
            }
        }
    }
}
