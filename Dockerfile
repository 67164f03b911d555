# The command line and the panel in a browser, from the sources of this folder:
#   docker build -t sdfstent .
#   docker run --rm --user "$(id -u):$(id -g)" -v "$PWD:/data" sdfstent measure surface.vtp --centerline centerline.vtp
#   docker run --rm -p 127.0.0.1:8080:8080 sdfstent app --demo --host 0.0.0.0 --port 8080
FROM python:3.12-slim
# What VTK loads to draw without a screen.
RUN apt-get update -qq \
 && apt-get install -y -qq --no-install-recommends libegl1 libgl1 libx11-6 libopengl0 libglx0 fonts-dejavu-core \
 && rm -rf /var/lib/apt/lists/*
COPY . /src
RUN pip install --no-cache-dir "/src[app,flow,vmtk]" && rm -rf /src
RUN useradd user && mkdir /data && chown user /data
USER user
# Files of a folder can be written by its owner alone, and one that --user names has no home.
ENV HOME=/tmp
WORKDIR /data
ENTRYPOINT ["sdfstent"]
