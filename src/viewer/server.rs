//! The server: three addresses with access control.
//!
//! | address | what |
//! |---|---|
//! | `/` | the page |
//! | `/live` | the WebSocket of the page |
//! | `/still.png` | the view with all its samples: the file that the job writes |

use std::{convert::Infallible, net::TcpListener, sync::Arc, time::Duration};

use axum::{
    Extension, Router,
    extract::{Request, State, WebSocketUpgrade},
    http::{HeaderValue, StatusCode, header},
    middleware::{self, Next},
    response::{Html, IntoResponse, Response},
    routing::get,
    serve::Listener,
};
use hyper::server::conn::http1;
use hyper_util::{rt::TokioIo, service::TowerToHyperService};
use tokio::{net::TcpStream, sync::watch};

use super::{
    connection,
    guard::Guard,
    page,
    session::Session,
    visitors::{Visitor, Visitors},
};
use crate::error::Error;

/// The most bytes of a message of a page.
const MAX_MESSAGE: usize = 16 << 10;

/// The interval at which the server checks whether to stop.
const STOP_POLL: Duration = Duration::from_millis(50);

/// The time for closing connections.
const GOODBYE: Duration = Duration::from_millis(500);

#[derive(Clone)]
struct Server {
    guard: Guard,
    session: Arc<Session>,
    visitors: Arc<Visitors>,
    /// Becomes true when the server stops.
    is_stopping: watch::Receiver<bool>,
}

/// Serves until `is_over`.
pub fn run(
    listener: TcpListener,
    guard: Guard,
    session: &Arc<Session>,
    is_over: &dyn Fn() -> bool,
) -> Result<(), Error> {
    let failed = |cause: std::io::Error| Error::Serve { cause };
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build()
        .map_err(failed)?;
    let (stopping, is_stopping) = watch::channel(false);
    let server = Server {
        guard,
        session: Arc::clone(session),
        visitors: Arc::default(),
        is_stopping,
    };
    let served = runtime.block_on(async {
        let listener = tokio::net::TcpListener::from_std(listener)?;
        tokio::select! {
            never = accept(listener, server) => match never {},
            () = over(is_over) => {
                stopping.send_replace(true);
                // Pages answer a close frame immediately.
                let _ = tokio::time::timeout(GOODBYE, stopping.closed()).await;
                Ok(())
            }
        }
    });
    runtime.shutdown_timeout(GOODBYE);
    served.map_err(failed)
}

/// Serves connections as they arrive.
async fn accept(mut listener: tokio::net::TcpListener, server: Server) -> Infallible {
    let visitors = Arc::clone(&server.visitors);
    let app = Router::new()
        .route("/", get(page))
        .route("/live", get(live))
        .route("/still.png", get(still))
        .layer(middleware::from_fn_with_state(server.clone(), check))
        .with_state(server);
    loop {
        // Errors of single connections are handled there.
        let (stream, _) = Listener::accept(&mut listener).await;
        let visitor = visitors.enter();
        let app = app.clone().layer(Extension(Arc::clone(&visitor)));
        tokio::spawn(serve(stream, app, Arc::clone(&visitors), visitor));
    }
}

/// Serves a connection until it ends or, without the secret, until it must.
async fn serve(stream: TcpStream, app: Router, visitors: Arc<Visitors>, visitor: Arc<Visitor>) {
    // Disables Nagle's algorithm; an error only costs latency.
    let _ = stream.set_nodelay(true);
    let connection = http1::Builder::new()
        .serve_connection(TokioIo::new(stream), TowerToHyperService::new(app))
        .with_upgrades();
    tokio::select! {
        // An error of a connection concerns nobody else.
        _ = connection => {}
        () = visitor.expired() => {}
    }
    visitors.leave(&visitor);
}

async fn over(is_over: &dyn Fn() -> bool) {
    while !is_over() {
        tokio::time::sleep(STOP_POLL).await;
    }
}

/// Checks every request with the guard.
async fn check(
    State(server): State<Server>,
    Extension(visitor): Extension<Arc<Visitor>>,
    request: Request,
    next: Next,
) -> Response {
    if let Err(status) = server.guard.check(request.uri(), request.headers()) {
        let reason = match status {
            StatusCode::FORBIDDEN => "this page needs the whole address that batch-render prints, with its key",
            _ => "this is not a name of the viewer",
        };
        return (status, reason).into_response();
    }
    server.visitors.admit(&visitor);
    let mut response = next.run(request).await;
    let headers = response.headers_mut();
    for (name, value) in [
        (header::CACHE_CONTROL, "no-store"),
        (header::REFERRER_POLICY, "no-referrer"),
        (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
    ] {
        headers.insert(name, HeaderValue::from_static(value));
    }
    response
}

async fn page() -> Response {
    let mut bytes = [0; 16];
    if getrandom::fill(&mut bytes).is_err() {
        return StatusCode::INTERNAL_SERVER_ERROR.into_response();
    }
    let nonce: String = bytes.iter().map(|byte| format!("{byte:02x}")).collect();
    let policy = [(header::CONTENT_SECURITY_POLICY, page::policy(&nonce))];
    (policy, Html(page::html(&nonce))).into_response()
}

async fn live(State(server): State<Server>, upgrade: WebSocketUpgrade, request: Request) -> Response {
    if let Err(status) = server.guard.check_origin(request.headers()) {
        return status.into_response();
    }
    let Server {
        session, is_stopping, ..
    } = server;
    upgrade
        .max_message_size(MAX_MESSAGE)
        .max_frame_size(MAX_MESSAGE)
        .on_upgrade(|socket| connection::run(socket, session, is_stopping))
}

/// Waits until the view has all its samples.
async fn still(State(server): State<Server>) -> Response {
    let mut pictures = server.session.pictures.subscribe();
    let mut is_stopping = server.is_stopping;
    let file = loop {
        let picture = pictures.borrow_and_update().clone();
        if let Some(picture) = picture.filter(|picture| server.session.is_final(picture)) {
            break picture.file().to_vec();
        }
        tokio::select! {
            changed = pictures.changed() => if changed.is_err() { return StatusCode::GONE.into_response() },
            () = connection::stopping(&mut is_stopping) => return StatusCode::GONE.into_response(),
        }
    };
    ([(header::CONTENT_TYPE, "image/png")], file).into_response()
}
