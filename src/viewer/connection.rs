//! The connection of one page: its messages, and the pictures and facts sent to it.
//!
//! A page gets the next picture after it has reported that the last one is drawn; pictures in between are skipped. A malformed or
//! too large message, or too many of them, end this connection and nothing else.

use std::{
    sync::Arc,
    time::{Duration, Instant},
};

use axum::{
    body::Bytes,
    extract::ws::{CloseFrame, Message, WebSocket, close_code},
};
use serde::Serialize;
use tokio::{sync::watch, time::timeout};

use super::{
    job,
    message::{Answer, KeysChange, PageMessage},
    numbers::{self, Misread},
    session::Session,
};

/// The limits of messages per second, and in a burst. A page at 240 pictures per second sends about as many.
const RATE: f64 = 600.0;
const BURST: f64 = 1200.0;

/// The time limit for sending to a page.
const SEND_TIMEOUT: Duration = Duration::from_secs(30);

/// Why a connection ends.
enum End {
    /// The page has gone.
    Gone,
    /// The page broke the protocol.
    Violation(&'static str),
    Stopping,
}

/// Serves a page until it closes.
pub async fn run(socket: WebSocket, session: Arc<Session>, is_stopping: watch::Receiver<bool>) {
    let mut connection = Connection {
        client: session.join(),
        socket,
        session,
        allowance: Allowance::full(),
    };
    let (code, reason) = match connection.serve(is_stopping).await {
        End::Gone => return,
        End::Violation(reason) => (close_code::POLICY, reason),
        End::Stopping => (close_code::AWAY, "the viewer has ended"),
    };
    let close = CloseFrame {
        code,
        reason: reason.into(),
    };
    let _ = timeout(SEND_TIMEOUT, connection.socket.send(Message::Close(Some(close)))).await;
}

struct Connection {
    client: u64,
    socket: WebSocket,
    session: Arc<Session>,
    allowance: Allowance,
}

impl Connection {
    async fn serve(&mut self, mut is_stopping: watch::Receiver<bool>) -> End {
        let session = Arc::clone(&self.session);
        let (mut pictures, mut facts) = (session.pictures.subscribe(), session.facts.subscribe());
        let (mut job, mut job_pictures) = (session.job.subscribe(), session.job_pictures.subscribe());
        let mut scene = session.scene.subscribe();
        let mut loads = scene.borrow().loads;
        let mut keys = session.keys.subscribe();
        let mut known_keys = Arc::default();
        pictures.mark_changed();
        facts.mark_changed();
        job.mark_changed();
        scene.mark_changed();
        keys.mark_changed();
        let mut is_drawing = false;
        if self.greet().await.is_err() {
            return End::Gone;
        }
        loop {
            let message = tokio::select! {
                biased;
                () = stopping(&mut is_stopping) => return End::Stopping,
                received = self.socket.recv() => match self.receive(received).await {
                    Ok(false) => continue,
                    Ok(true) => { is_drawing = false; continue }
                    Err(end) => return end,
                },
                // Before the pictures: a page must know a scene to show it.
                Ok(()) = scene.changed() => {
                    let facts = scene.borrow_and_update().clone();
                    if facts.loads != loads && self.greet().await.is_err() {
                        return End::Gone;
                    }
                    loads = facts.loads;
                    json(&facts)
                }
                Ok(()) = pictures.changed(), if !is_drawing => {
                    let picture = pictures.borrow_and_update().clone();
                    let Some(picture) = picture else { continue };
                    is_drawing = true;
                    Message::Binary(Bytes::copy_from_slice(picture.message()))
                }
                Ok(()) = facts.changed() => Message::text(facts.borrow_and_update().to_string()),
                Ok(()) = keys.changed() => {
                    let new = Arc::clone(&keys.borrow_and_update());
                    let change = json(&KeysChange::between(&known_keys, &new));
                    known_keys = new;
                    change
                }
                Ok(()) = job.changed() => {
                    let facts = job.borrow_and_update().clone();
                    json(&facts)
                }
                Ok(()) = job_pictures.changed() => {
                    let picture = job_pictures.borrow_and_update().clone();
                    let Some(picture) = picture else { continue };
                    Message::Binary(Bytes::copy_from_slice(picture.message()))
                }
            };
            if self.send(message).await.is_err() {
                return End::Gone;
            }
        }
    }

    /// Handles a message. Returns whether it reports a drawn picture.
    async fn receive(&mut self, received: Option<Result<Message, axum::Error>>) -> Result<bool, End> {
        let text = match received {
            None | Some(Ok(Message::Close(_))) => return Err(End::Gone),
            // A message is too large, or no WebSocket frame.
            Some(Err(_)) => return Err(End::Violation("a message that cannot be read")),
            Some(Ok(Message::Binary(_))) => return Err(End::Violation("a binary message")),
            Some(Ok(Message::Ping(_) | Message::Pong(_))) => {
                return self.allowance.take().map(|()| false);
            }
            Some(Ok(Message::Text(text))) => text,
        };
        self.allowance.take()?;
        let answer = match numbers::read(&text) {
            Ok(PageMessage::Ack) => return Ok(true),
            Ok(message) => self.obey(message),
            Err(Misread::Number { seq, text }) => Some(Answer::refusal(seq, text)),
            Err(Misread::Malformed) => return Err(End::Violation("a message that says nothing")),
        };
        if let Some(answer) = answer {
            self.send(json(&answer)).await.map_err(|()| End::Gone)?;
        }
        Ok(false)
    }

    fn obey(&self, message: PageMessage) -> Option<Answer> {
        let (session, client) = (&self.session, self.client);
        let seq = message.seq();
        let done = match message {
            PageMessage::View { seq, camera } => session.set_camera((client, seq), camera),
            PageMessage::Home { seq } => session.go_home((client, seq)),
            PageMessage::Frame { seq, frame } => session.set_frame((client, seq), frame),
            PageMessage::Look { seq, look } => session.set_look((client, seq), look),
            PageMessage::Pick { id, x, y } => return Some(session.pick(id, [x, y])),
            PageMessage::Set => session.set_key(),
            PageMessage::Move { from, to } => session.move_key(from, to),
            PageMessage::Delete { frame } => session.delete_key(frame),
            PageMessage::Save { force } => return Some(session.save(force)),
            PageMessage::Load => {
                return Some(match session.load() {
                    Ok(()) => Answer::done("loaded the camera path"),
                    Err(error) => Answer::error(error),
                });
            }
            PageMessage::Reload => {
                session.ask_for_load();
                Ok(())
            }
            PageMessage::Render => job::start(session),
            PageMessage::Cancel => {
                session.cancel_job();
                Ok(())
            }
            PageMessage::Ack => Ok(()),
        };
        done.err().map(|error| Answer::refusal(seq, error))
    }

    /// Sends the facts of the scene.
    async fn greet(&mut self) -> Result<(), ()> {
        let hello = self.session.base().hello(self.client);
        self.send(Message::text(hello)).await
    }

    async fn send(&mut self, message: Message) -> Result<(), ()> {
        match timeout(SEND_TIMEOUT, self.socket.send(message)).await {
            Ok(Ok(())) => Ok(()),
            _ => Err(()),
        }
    }
}

fn json(message: &impl Serialize) -> Message {
    Message::text(serde_json::to_string(message).expect("messages are numbers and words"))
}

/// Waits until the server stops.
pub async fn stopping(is_stopping: &mut watch::Receiver<bool>) {
    // An error means that the server is gone.
    let _ = is_stopping.wait_for(|stopping| *stopping).await;
}

/// The number of messages that a page may still send.
struct Allowance {
    left: f64,
    since: Instant,
}

impl Allowance {
    fn full() -> Self {
        Self {
            left: BURST,
            since: Instant::now(),
        }
    }

    fn take(&mut self) -> Result<(), End> {
        let now = Instant::now();
        self.left = (self.left + RATE * (now - self.since).as_secs_f64()).min(BURST) - 1.0;
        self.since = now;
        if self.left < 0.0 {
            return Err(End::Violation("too many messages"));
        }
        Ok(())
    }
}
